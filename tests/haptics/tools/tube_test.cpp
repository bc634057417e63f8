#include "haptics/tools/tube.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "haptics/tools/instrument.h"
#include "tests/haptics/column.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using enum patient::Tissue;

struct TubeBench {
    TubeBench() { path.length_m = pathLength_m(points_m); }

    void push(double travel_m, double step_m = 0.00005) {
        const auto ticks = std::lround(std::fabs(travel_m) / step_m);
        for (long i = 0; i < ticks; ++i) {
            const double moved_m = std::copysign(step_m, travel_m);
            const double before_n = force_n;
            force_n = stepTube(tube, settings, path, opening, patient, moved_m);
            work_j += (moved_m > 0.0 ? std::max(before_n, force_n) : std::min(before_n, force_n)) * moved_m;
            if (opening.dilated_m < tube.depth_m - settings.taper_m)
                opening.dilated_m = tube.depth_m - settings.taper_m, opening.diameter_m = settings.outer_m;
            EXPECT_GE(work_j + 1e-9, tubeEnergy_j(tube, settings));
        }
    }

    patient::Package package = test::makeColumn({{skin, 0.002}, {soft, 0.028}, {liver, 0.05}});
    patient::Patient patient{package};
    std::vector<Vec3> points_m{{0.0, 0.0, 0.0}, {0.040, 0.0, 0.0}, {0.060, 0.0, 0.0}};
    TubePath path{points_m, 0.0};
    TubeSettings settings;
    Opening opening;
    TubeState tube;
    double force_n = 0.0, work_j = 0.0;
};

TEST(Tube, PointsOfThePathContinueStraight) {
    const TubeBench b;
    EXPECT_EQ(pointAt(b.path, 0.010), Vec3(0.010, 0.0, 0.0));
    EXPECT_NEAR(pointAt(b.path, 0.050).x, 0.050, 1e-12);
    EXPECT_NEAR(pointAt(b.path, -0.010).x, -0.010, 1e-12);
    EXPECT_NEAR(pointAt(b.path, 0.100).x, 0.100, 1e-12);
}

// Deep in one tissue with its whole taper: friction and widening in closed form.
TEST(Tube, ForceFollowsTissueAndDiameters) {
    TubeBench b;
    const patient::TissueRow& liver_row = b.patient.row(liver);
    for (const double outer_m : {0.002, 0.00267, 0.004}) {
        b.settings.outer_m = outer_m;
        const TubeResistance r = tubeResistance(b.settings, b.path, b.opening, b.patient, 0.055);
        const double scale = outer_m / kPaperNeedle_m;
        EXPECT_NEAR(r.friction_n, scale * liver_row.friction_n, 1e-12);
        EXPECT_NEAR(r.widening_n, scale * liver_row.cut_force_n * (1.0 - b.opening.needle_m / outer_m),
                    1e-12);
        const Opening wide{0.060, outer_m, b.opening.needle_m};
        EXPECT_EQ(tubeResistance(b.settings, b.path, wide, b.patient, 0.055).widening_n, 0.0);
    }
    EXPECT_EQ(tubeResistance(b.settings, b.path, b.opening, b.patient, -0.001).friction_n, 0.0);
}

TEST(Tube, ADilatedTrackResistsLess) {
    TubeBench b;
    b.push(0.059);
    const double first_n = b.force_n, depth_m = b.tube.depth_m;
    EXPECT_GT(depth_m, 0.050);
    b.push(-0.080);
    EXPECT_LT(b.tube.depth_m, 0.0);
    EXPECT_EQ(b.force_n, 0.0);
    b.push(0.040 - b.tube.depth_m);
    const double again_n = b.force_n;
    TubeBench intact;
    intact.push(0.040);
    EXPECT_LT(again_n, intact.force_n - 0.1);
    EXPECT_LT(again_n, first_n - 0.1);
}

TEST(Tube, StopsBluntlyWhereTheWireEnds) {
    TubeBench b;
    b.push(0.120);
    EXPECT_NEAR(b.tube.depth_m, 0.060, 1e-9);
    EXPECT_TRUE(b.tube.stopped);
    const TubeResistance r = tubeResistance(b.settings, b.path, b.opening, b.patient, 0.060);
    EXPECT_NEAR(b.force_n, r.friction_n + r.widening_n + b.settings.blunt_n, 1e-9);
}

// Without a wire the path is not open: the tube does not enter the skin.
TEST(Tube, DoesNotAdvanceWithoutAWire) {
    TubeBench b;
    b.path.length_m = 0.0;
    b.push(0.050);
    EXPECT_EQ(b.tube.depth_m, 0.0);
    EXPECT_NEAR(b.force_n, b.settings.blunt_n, 1e-9);
    b.push(-0.010);
    EXPECT_LT(b.tube.depth_m, 0.0);
}

TEST(Tube, IgnoresWhatIsNotANumber) {
    TubeBench b;
    b.push(0.010);
    const double depth_m = b.tube.depth_m;
    EXPECT_TRUE(std::isfinite(stepTube(b.tube, b.settings, b.path, b.opening, b.patient, std::nan(""))));
    EXPECT_NEAR(b.tube.depth_m, depth_m, 1e-4);
    EXPECT_LE(stepTube(b.tube, b.settings, b.path, b.opening, b.patient, 1e300), 22.0);
}

}  // namespace
}  // namespace stylet::haptics
