// Critical errors from hand-made ticks: one per structure, and the tries to hide them.
#include "app/training/safety.h"

#include <gtest/gtest.h>

#include "tests/app/training/wall.h"

namespace stylet::training {
namespace {

using haptics::TickOutput;
using patient::BloodKind;
using patient::Role;
using patient::Structure;
using patient::Tissue;

class SafetyTest : public testing::Test {
  protected:
    SafetyTest() {
        package_.label_table[test::kVesselLabel - 1].role = Role::risk;
        package_.label_table[test::kVesselLabel - 1].blood = BloodKind::portal;
    }
    void needleAt(double x_m, Tissue tissue, std::uint8_t label, double y_m = 0.0) {
        TickOutput now;
        now.tip_reference_m = {x_m, y_m, 0.0};
        now.depth_m = x_m, now.tissue = tissue, now.label = label;
        now.phase = x_m > 0.0 ? haptics::Phase::pass : haptics::Phase::outside;
        TickFacts facts;
        facts.inside = x_m > 0.0;
        watch_.update(now, facts);
    }
    // Makes the wall's bone slab another structure of the role "risk" and puts the tip into it.
    std::uint32_t errorsIn(Structure structure, Tissue tissue, Role role = Role::risk) {
        patient::Label& label = package_.label_table[test::kBoneLabel - 1];
        label.structure = structure, label.tissue = tissue, label.role = role;
        watch_ = SafetyWatch(patient_);
        needleAt(0.010, tissue, test::kBoneLabel);
        return watch_.errors();
    }
    static std::uint32_t bit(CriticalError error) { return 1u << unsigned(error); }

    patient::Package package_ = test::wallWithVessel();
    patient::Patient patient_{package_};
    SafetyWatch watch_{patient_};
};

TEST_F(SafetyTest, OneTickInAVitalStructureIsCritical) {
    EXPECT_EQ(errorsIn(Structure::lung, Tissue::air), bit(CriticalError::lung));
    EXPECT_EQ(errorsIn(Structure::gas, Tissue::air), bit(CriticalError::bowel));
    for (const Structure hollow : {Structure::stomach, Structure::colon, Structure::small_bowel})
        EXPECT_EQ(errorsIn(hollow, Tissue::soft), bit(CriticalError::bowel));
    EXPECT_EQ(errorsIn(Structure::gallbladder, Tissue::soft), bit(CriticalError::gallbladder));
    EXPECT_EQ(errorsIn(Structure::heart, Tissue::vessel), bit(CriticalError::majorVessel));
    EXPECT_EQ(errorsIn(Structure::kidney, Tissue::soft), 0u);
    EXPECT_EQ(errorsIn(Structure::gallbladder, Tissue::soft, Role::pass), 0u) << "the instructor allows it";
}

TEST_F(SafetyTest, BranchIsCriticalOnlyIfTheNeedleRunsFarInIt) {
    for (double x_m = 0.032; x_m <= 0.0362; x_m += 0.0005)
        needleAt(x_m, Tissue::vessel, test::kVesselLabel);
    needleAt(0.037, Tissue::liver, test::kLiverLabel);
    EXPECT_EQ(watch_.errors(), 0u) << "across a branch of 4 mm";
    for (int n = 0; n < 5; ++n) {  // to and fro in the same branch is not far
        needleAt(0.035, Tissue::vessel, test::kVesselLabel);
        needleAt(0.033, Tissue::vessel, test::kVesselLabel);
    }
    EXPECT_EQ(watch_.errors(), 0u);
    for (double y_m = 0.0; y_m <= 0.0065; y_m += 0.0005)
        needleAt(0.034, Tissue::vessel, test::kVesselLabel, y_m);
    EXPECT_EQ(watch_.errors(), bit(CriticalError::majorVessel)) << "along it";
}

TEST_F(SafetyTest, ArteryIsCriticalAtOnce) {
    package_.label_table[test::kVesselLabel - 1].blood = BloodKind::artery;
    needleAt(0.034, Tissue::vessel, test::kVesselLabel);
    EXPECT_EQ(watch_.errors(), bit(CriticalError::majorVessel));
}

TEST_F(SafetyTest, FourthHoleInTheCapsuleIsCritical) {
    const auto insert = [&](double y_m) {
        needleAt(0.015, Tissue::soft, 2, y_m);
        needleAt(0.025, Tissue::liver, test::kLiverLabel, y_m);
        needleAt(0.034, Tissue::vessel, test::kVesselLabel, y_m);
        needleAt(0.040, Tissue::liver, test::kLiverLabel, y_m);
    };
    for (int n = 0; n < 6; ++n)
        insert(0.0);
    EXPECT_EQ(watch_.capsulePunctures(), 1) << "the same hole again";
    insert(0.004), insert(0.008);
    EXPECT_EQ(watch_.errors(), 0u);
    insert(0.012);
    EXPECT_EQ(watch_.capsulePunctures(), 4);
    EXPECT_EQ(watch_.errors(), bit(CriticalError::capsule));
    needleAt(-0.010, Tissue::air, 0);
    EXPECT_EQ(watch_.errors(), bit(CriticalError::capsule)) << "drawing out undoes nothing";
}

}  // namespace
}  // namespace stylet::training
