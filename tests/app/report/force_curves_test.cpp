#include "app/report/force_curves.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/phantom.h"
#include "tests/support/temp_folder.h"

namespace stylet::report {
namespace {

using haptics::Tissue;

const TissueCurve& curveInto(const std::vector<TissueCurve>& curves, Tissue tissue) {
    for (const TissueCurve& c : curves)
        if (c.tissue == tissue) return c;
    throw std::runtime_error("no such curve");
}

double at(const std::vector<DepthForce>& way, double depth_m) {
    for (const DepthForce& d : way)
        if (std::fabs(d.depth_m - depth_m) < 5e-6) return d.force_n;
    ADD_FAILURE() << "no sample at " << depth_m;
    return 0.0;
}

class ForceCurves : public testing::Test {
  protected:
    const patient::TissueTable& table_ = test::tissueDefaults().tissues;
    std::vector<TissueCurve> curves_ = tissueCurves(table_, {});
};

TEST_F(ForceCurves, PunctureMatchesClosedForm) {
    ASSERT_EQ(curves_.size(), std::size_t(patient::kTissueCount - 1));
    const std::pair<Tissue, double> cuts[] = {{Tissue::skin, 0.7 / 800.0},
                                              {Tissue::fascia, 1.8 / 1000.0},
                                              {Tissue::vessel, 0.15 / 1100.0},
                                              {Tissue::duct, 0.3 / 1000.0},
                                              {Tissue::cartilage, 2.1 / 1300.0}};
    for (const auto& [tissue, behind_m] : cuts) {
        const TissueCurve& c = curveInto(curves_, tissue);
        EXPECT_TRUE(c.cut);
        EXPECT_NEAR(c.cut_at.depth_m, behind_m, 1e-9);
        EXPECT_NEAR(c.cut_at.force_n, table_[std::size_t(tissue)].cut_force_n, 1e-9);
    }
    for (const Tissue tissue : {Tissue::soft, Tissue::liver, Tissue::bone})
        EXPECT_FALSE(curveInto(curves_, tissue).cut);
}

TEST_F(ForceCurves, EndInFrictionInAndOut) {
    for (const TissueCurve& c : curves_) {
        if (c.tissue == Tissue::bone) continue;
        const double friction_n = table_[std::size_t(c.tissue)].friction_n;
        EXPECT_NEAR(c.in.back().force_n, friction_n, 1e-9);
        EXPECT_NEAR(at(c.out, 0.001), -friction_n, 1e-9);
    }
}

TEST_F(ForceCurves, LieBetweenTheBoundsOfEquation1) {
    const TissueCurve& c = curveInto(curves_, Tissue::fascia);
    for (const double d : {0.0004, 0.0009, 0.0015}) {
        EXPECT_LT(at(c.min_a1, d), at(c.in, d));
        EXPECT_LT(at(c.in, d), at(c.max_a1, d));
    }
}

TEST_F(ForceCurves, AreDrawnAsPng) {
    const test::TempFolder folder;
    drawTissueCurves(curves_, table_, folder / "tissues.png");
    EXPECT_GT(std::filesystem::file_size(folder / "tissues.png"), 20000u);
    EXPECT_THROW(drawTissueCurves(curves_, table_, "/nonexistent/tissues.png"), DataError);
}

}  // namespace
}  // namespace stylet::report
