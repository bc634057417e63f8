#include "app/trainer/session/force_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

#include "patient/package/segmentation.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using patient::Label;
using patient::Tissue;

OtherSegmentation asIf(const patient::Package& package, bool (*segmented)(const Label&)) {
    OtherSegmentation other;
    other.patient = std::make_unique<patient::Patient>(package, segmented);
    return other;
}

SessionLog played(const patient::Patient& patient, const std::string& scenario_file, ForceComparison* truth) {
    const Scenario scenario = loadScenario(scenario_file);
    const Attempt attempt = makeAttempt(patient, scenario, test::ductPath(), 1);
    Session session(patient, test::ductPath(), scenario.moments, scenario.approach_distance_m, nullptr);
    if (truth) session.compareWith(*truth);
    runFast(attempt, session, nullptr, 0.0, {});
    return session.log();
}

std::string fiveToolsFile() {
    return (test::assets() / "scenarios" / "five-tools.toml").string();
}

// The attempt uses finger, probe, incision, guide and breath, and therefore every input of the needle model.
TEST(ForceComparison, EqualSegmentationsGiveExactlyZeroError) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const OtherSegmentation same = asIf(package, [](const Label&) { return true; });
    ForceComparison truth(same, haptics::NeedleSettings{});
    const SessionLog log = played(patient, fiveToolsFile(), &truth);
    ASSERT_TRUE(log.target_hit());
    EXPECT_EQ(log.truth.insertions, 1u);
    EXPECT_GT(log.truth.all.ticks, 1000u);
    EXPECT_EQ(log.truth.all.equal_ticks, log.truth.all.ticks);
    EXPECT_EQ(log.truth.all.largest_n, 0.0);
    EXPECT_EQ(log.state_hash, played(patient, fiveToolsFile(), nullptr).state_hash) << "it is only read";
}

// Pushes a needle along the slabs and computes its force on `patient`.
class Pushed {
  public:
    Pushed(const patient::Patient& patient, ForceComparison& truth) : patient_(patient), truth_(truth) {
        now_.tool_awaits_exit = false;
    }
    const ForceComparisonReading& to(double x_m) {
        for (; x_m_ < x_m - 1e-9; x_m_ += kStep_m)
            at(x_m_ + kStep_m);
        return truth_.reading();
    }
    static constexpr double kStep_m = 0.00001;

  private:
    void at(double x_m) {
        now_.patient_from_needle = {{0.70710678118654752, 0.0, -0.70710678118654752, 0.0},
                                    {x_m, 0.0003, 0.0002}};  // along +x
        haptics::stepNeedle(
            felt_, {}, {patient_, {}},
            {now_.patient_from_needle.position_m, now_.patient_from_needle.direction({0.0, 0.0, -1.0})},
            events_);
        ++now_.tick;
        now_.phase = felt_.phase;
        now_.force_n = felt_.force_n;
        now_.depth_m = felt_.depth_m;
        truth_.update(now_);
    }
    const patient::Patient& patient_;
    ForceComparison& truth_;
    haptics::NeedleState felt_;
    haptics::NeedleEvents events_;
    haptics::TickOutput now_;
    double x_m_ = -0.005;
};

// Without its label the duct (50 to 56 mm) is classified by its CT value, as soft tissue: the force is 0.7 N
// of friction from its border on. With the label the duct's wall tents first: within 0.3 mm of the border the
// force rises from 0.9 to 1.2 N. Then the wall is cut, and the force is 0.5 N.
TEST(ForceComparison, MissingDuctCausesTheErrorOfTheForceLaw) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const OtherSegmentation missed =
        asIf(package, [](const Label& label) { return label.tissue != Tissue::duct; });
    ForceComparison truth(missed, {});
    Pushed needle(patient, truth);
    EXPECT_EQ(needle.to(0.0495).insertion.equal_ticks, truth.reading().insertion.ticks);
    EXPECT_EQ(truth.reading().insertion.largest_n, 0.0);
    // Halfway through tenting: f = a2 d^2 + a1 d + a0 with a1 = k/2, d = 0.15 mm.
    const double k = 1000.0, a1 = 0.5 * k, a2 = k * (k - a1) / 0.3, d = 0.00015;
    EXPECT_NEAR(needle.to(0.05 + d).full_n, 0.9 + a1 * d + a2 * d * d, 2.0 * k * Pushed::kStep_m);
    EXPECT_NEAR(truth.reading().partial_n, 0.7, 1e-9);
    EXPECT_NEAR(needle.to(0.0540).error_n(), 0.2, 1e-9);
    EXPECT_NEAR(truth.reading().insertion.largest_n, 0.5, 2.0 * k * Pushed::kStep_m);
    EXPECT_NEAR(truth.reading().insertion.largest_depth_m, 0.0503, 2.0 * Pushed::kStep_m);
    const ForceError& error = truth.reading().insertion;
    EXPECT_LT(error.rms_n(), error.largest_n);
    EXPECT_NEAR(error.rms_n() * error.rms_n() * double(error.ticks), error.sum_n2, 1e-9);
}

// The fascia has no label in the partial segmentation, and its CT value is that of soft tissue. The needle
// feels 0.7 N there instead of up to 2.5 N.
TEST(ForceComparison, ReadingNamesTheFeltSegmentation) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient felt(package, [](const Label& label) { return label.tissue != Tissue::fascia; });
    OtherSegmentation full = asIf(package, [](const Label&) { return true; });
    full.felt_is_full = false;
    ForceComparison truth(full, {});
    Pushed needle(felt, truth);
    needle.to(0.0200 + 0.0017);
    EXPECT_LT(truth.reading().error_n(), -1.0) << "partial minus full";
    EXPECT_NEAR(truth.reading().partial_n, 0.7, 1e-9);
    EXPECT_EQ(truth.reading().other_n(), truth.reading().full_n);
    EXPECT_GT(truth.reading().full_n, 2.0);
}

TEST(ForceComparison, EachInsertionStartsNewStatistics) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const OtherSegmentation missed =
        asIf(package, [](const Label& label) { return label.tissue != Tissue::duct; });
    ForceComparison truth(missed, {});
    haptics::TickOutput now;
    now.tool_awaits_exit = false;
    const auto tick = [&](double depth_m, double force_n) {
        ++now.tick;
        now.phase = depth_m > 0.0 ? haptics::Phase::pass : haptics::Phase::outside;
        now.patient_from_needle.position_m = {-0.01, 0.0, 0.0};  // the other needle stays outside: 0 N
        now.force_n = force_n, now.depth_m = depth_m;
        truth.update(now);
    };
    tick(0.0, 0.0), tick(0.01, 2.0), tick(0.02, 1.0), tick(0.0, 0.0), tick(0.005, -0.5);
    EXPECT_EQ(truth.reading().insertions, 2u);
    EXPECT_EQ(truth.reading().insertion.ticks, 1u);
    EXPECT_DOUBLE_EQ(truth.reading().insertion.largest_n, 0.5);
    EXPECT_EQ(truth.reading().all.ticks, 3u);
    EXPECT_DOUBLE_EQ(truth.reading().all.largest_n, 2.0);
    EXPECT_DOUBLE_EQ(truth.reading().all.largest_depth_m, 0.01);
    EXPECT_DOUBLE_EQ(truth.reading().all.rms_n(), std::sqrt((4.0 + 1.0 + 0.25) / 3.0));
}

TEST(ForceComparison, PartialPatientNeedsAFullPackage) {
    const test::TempFolder folder;
    const patient::Package full = test::ductPhantom();
    patient::savePackage(full, folder / "full");
    const patient::Patient full_patient(full);
    const auto partial = loadOtherSegmentation(full_patient, {});
    ASSERT_TRUE(partial);
    EXPECT_TRUE(partial->felt_is_full);
    const Vec3 in_skin{0.0015, 0.0, 0.0}, in_duct{0.053, 0.0, 0.0};
    EXPECT_EQ(partial->patient->at(in_skin, {}).label, 0);
    EXPECT_EQ(partial->patient->at(in_duct, {}).tissue, Tissue::duct);

    patient::Package bare = full;
    bare.labels = LabelVolume(full.ct.grid);
    const patient::Patient bare_patient(bare);
    EXPECT_FALSE(loadOtherSegmentation(bare_patient, {}));
    const auto truth = loadOtherSegmentation(bare_patient, folder / "full");
    ASSERT_TRUE(truth);
    EXPECT_FALSE(truth->felt_is_full);
    EXPECT_NE(truth->patient->at(in_skin, {}).label, 0);

    patient::savePackage(bare, folder / "bare");
    test::expectRefused([&] { loadOtherSegmentation(bare_patient, folder / "bare"); }, "bare",
                        "labels.nii.gz");
    bare.ct.voxels[0] = 7;
    test::expectRefused([&] { loadOtherSegmentation(bare_patient, folder / "full"); }, "full", "ct.nii.gz");
}

}  // namespace
}  // namespace stylet::trainer
