#include "app/training/attempt_fold.h"

#include <gtest/gtest.h>

#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/constants.h"

namespace stylet::training {
namespace {

using haptics::Command;
using haptics::CommandKind;
using haptics::TickInput;
using haptics::TickOutput;
using test::kDt_s;

// Ticks with the needle's tip in the duct of the phantom.
class AttemptFoldTest : public testing::Test {
  protected:
    std::uint64_t tick(AttemptFold& fold, std::initializer_list<Command> commands = {}) {
        TickInput input;
        for (const Command& c : commands)
            input.commands[input.command_count++] = c;
        output_.tick += 1;
        output_.state_hash = 0x1234'5678ull * output_.tick;
        return fold.step(input, output_);
    }
    void SetUp() override {
        output_.phase = haptics::Phase::pass;
        output_.tip_reference_m = {0.053, 0.0, 0.0};
    }
    patient::Package package_ = test::ductPhantom();
    patient::Patient patient_{package_};
    TickOutput output_;
};

TEST_F(AttemptFoldTest, EqualsTheSimulationHashUntilEquipmentIsUsed) {
    AttemptFold fold(patient_, kDt_s);
    EXPECT_EQ(tick(fold), output_.state_hash);
    EXPECT_EQ(tick(fold, {{CommandKind::holdBreath, 0}, {CommandKind::marker, 7}}), output_.state_hash);
    EXPECT_FALSE(fold.begun());
    EXPECT_NE(tick(fold, {kPedalDown}), output_.state_hash);
    EXPECT_TRUE(fold.begun());
    EXPECT_NE(tick(fold), output_.state_hash);
}

// Whoever changes an answer in a record changes its hash, also before equipment is used.
TEST_F(AttemptFoldTest, AnswersAreHashedInTheirOrder) {
    const auto hashAfter = [&](std::initializer_list<Command> answers, bool pedal) {
        AttemptFold fold(patient_, kDt_s);
        output_.tick = 0;
        std::uint64_t hash = 0;
        for (const Command& answer : answers)
            hash = tick(fold, {answer});
        return pedal ? tick(fold, {kPedalDown}) : hash;
    };
    for (const bool pedal : {false, true}) {
        EXPECT_EQ(hashAfter({kYes, kNo}, pedal), hashAfter({kYes, kNo}, pedal));
        EXPECT_NE(hashAfter({kYes, kNo}, pedal), hashAfter({kNo, kYes}, pedal));
        EXPECT_NE(hashAfter({kNo, kNo}, pedal), hashAfter({kNo, {CommandKind::marker, 7}}, pedal));
    }
}

TEST_F(AttemptFoldTest, ContrastAndDoseFollowTheCommandsTickByTick) {
    AttemptFold fold(patient_, kDt_s);
    tick(fold, {kPedalDown, injectCommand(2e-6)});
    for (int i = 1; i < 1000; ++i)
        tick(fold);
    tick(fold, {kPedalUp, injectCommand(0.0)});
    for (int i = 0; i < 500; ++i)
        tick(fold);
    EXPECT_NEAR(fold.contrast().volumes().ducts_m3, 2e-6, 1e-12);
    EXPECT_NEAR(fold.dose().contrast_m3, 2e-6, 1e-12);
    EXPECT_NEAR(fold.dose().fluoroscopy_s, 1.0, 1e-9);
    EXPECT_EQ(fold.contrast().status().place, patient::ContrastPlace::duct);
    EXPECT_EQ(fold.equipment().xray.pulses, fold.dose().pulses);
}

// One syringe at a time.
TEST_F(AttemptFoldTest, LocalAnaestheticReplacesContrastMedium) {
    output_.tip_reference_m = {0.010, 0.0, 0.0};
    output_.tissue = patient::Tissue::soft;
    AttemptFold fold(patient_, kDt_s);
    tick(fold, {injectCommand(2e-6)});
    EXPECT_FALSE(fold.anaesthetic().begun());
    tick(fold, {anaesthetiseCommand(1e-6)});
    EXPECT_EQ(fold.equipment().injected_m3_per_s, 0.0);
    for (int i = 1; i < 1000; ++i)
        tick(fold);
    tick(fold, {injectCommand(0.0)});
    tick(fold);
    EXPECT_NEAR(fold.anaesthetic().volumes().tissue_m3, 1e-6, 1e-12);
    EXPECT_NEAR(fold.dose().anaesthetic_m3, 1e-6, 1e-12);
    EXPECT_NEAR(fold.dose().contrast_m3, 2e-9, 1e-15);
    EXPECT_EQ(fold.equipment().anaesthetic_m3_per_s, 0.0);
}

TEST_F(AttemptFoldTest, LocalAnaestheticOutsideTheBodyOrInAnAccessIsLost) {
    AttemptFold fold(patient_, kDt_s);
    output_.tissue = patient::Tissue::soft;
    output_.access.open = true;
    tick(fold, {anaesthetiseCommand(1e-6)});
    output_.access.open = false, output_.phase = haptics::Phase::outside;
    tick(fold);
    EXPECT_NEAR(fold.anaesthetic().volumes().lost_m3, 2e-9, 1e-15);
    output_.phase = haptics::Phase::pass, output_.tissue = patient::Tissue::air, output_.depth_m = 0.003;
    tick(fold);
    EXPECT_NEAR(fold.anaesthetic().volumes().tissue_m3, 1e-9, 1e-15) << "a voxel artefact at the skin";
}

TEST_F(AttemptFoldTest, AnInjectionOutsideTheBodyIsLost) {
    AttemptFold fold(patient_, kDt_s);
    output_.phase = haptics::Phase::outside;
    tick(fold, {injectCommand(2e-6)});
    EXPECT_NEAR(fold.contrast().volumes().lost_m3, 2e-9, 1e-15);
}

// The duct begins at x = 50 mm. The drain's end runs along z at these distances before it, from the tip on.
haptics::AccessOutput drainBesideDuct(double tip_m, double behind_m) {
    haptics::AccessOutput access;
    access.drain = haptics::DrainState::in_place;
    access.drain_m = 0.030;
    access.path_count = 3;
    access.path_m[0] = {0.050f - float(behind_m), 0.0f, -0.015f};
    access.path_m[1] = {0.050f - float(behind_m), 0.0f, 0.005f};
    access.path_m[2] = {0.050f - float(tip_m), 0.0f, 0.015f};
    return access;
}

// The drain follows the wire, which may run in the wall of the duct. Its holes are on its surface.
TEST_F(AttemptFoldTest, MediumFlowsThroughADrainWhoseSurfaceOpensIntoTheDuct) {
    const auto shareInDucts = [&](double beside_m, const haptics::TubeSettings& drain) {
        AttemptFold fold(patient_, kDt_s);
        fold.setDrain(drain);
        output_.access = drainBesideDuct(beside_m, beside_m);
        tick(fold, {injectCommand(2e-6)});
        return fold.contrast().volumes().ducts_m3 / fold.contrast().volumes().injected_m3;
    };
    haptics::TubeSettings thick = haptics::kDrainDefaults;
    thick.outer_m = 0.004;
    for (const haptics::TubeSettings& drain : {haptics::kDrainDefaults, thick}) {
        EXPECT_EQ(shareInDucts(-0.001, drain), 1.0) << "the axis runs in the duct";
        EXPECT_EQ(shareInDucts(0.5 * drain.outer_m - 0.0003, drain), 1.0);
        EXPECT_EQ(shareInDucts(0.5 * drain.outer_m + 0.0003, drain), 0.0);
    }
}

// Records made before the surface counted replay to the same hash.
TEST_F(AttemptFoldTest, MediumLeavesWhereTheAxisLiesInTheDuctFirst) {
    const auto hashAfter = [&](double radius_m) {
        AttemptFold fold(patient_, kDt_s);
        haptics::TubeSettings drain = haptics::kDrainDefaults;
        drain.outer_m = 2.0 * radius_m;
        fold.setDrain(drain);
        output_.tick = 0;
        output_.access = drainBesideDuct(0.001, -0.002);
        return tick(fold, {injectCommand(2e-6)});
    };
    EXPECT_EQ(hashAfter(0.0014), hashAfter(0.0001)) << "the tip opens on its surface, or not at all";
}

TEST_F(AttemptFoldTest, EachPressOfThePedalAimsAtTheNeedleInTheBody) {
    AttemptFold fold(patient_, kDt_s);
    const auto press = [&](double x_m) {
        output_.patient_from_needle.position_m = {x_m, 0.0, 0.0};
        tick(fold, {kPedalDown});
        tick(fold, {kPedalUp});
        return fold.equipment().xray.aimed_m;
    };
    output_.phase = haptics::Phase::outside;
    EXPECT_FALSE(press(-0.02));
    output_.phase = haptics::Phase::pass;
    EXPECT_EQ(press(0.03), Vec3(0.03, 0.0, 0.0));
    EXPECT_EQ(press(0.05), Vec3(0.05, 0.0, 0.0));
    output_.phase = haptics::Phase::outside;
    EXPECT_EQ(press(-0.02), Vec3(0.05, 0.0, 0.0)) << "the needle is out: the C-arm stays";
}

TEST_F(AttemptFoldTest, HashCoversEveryCommandAndItsTick) {
    const auto play = [&](const Command& command, int at) {
        AttemptFold fold(patient_, kDt_s);
        output_.tick = 0;
        std::uint64_t hash = 0;
        for (int i = 0; i < 200; ++i)
            hash = i == at ? tick(fold, {command}) : tick(fold);
        return hash;
    };
    const std::uint64_t first = play(injectCommand(1e-6), 10);
    EXPECT_EQ(play(injectCommand(1e-6), 10), first);
    EXPECT_NE(play(injectCommand(1e-6), 11), first);
    EXPECT_NE(play(injectCommand(1.001e-6), 10), first);
    EXPECT_NE(play(kPedalDown, 10), play(kPedalDown, 11));
    EXPECT_NE(play(knobCommand(XrayKnob::rotation, 1.0), 10), play(knobCommand(XrayKnob::rotation, 1.1), 10));
    EXPECT_NE(play(knobCommand(UltrasoundKnob::gain, 1.0), 10),
              play(knobCommand(UltrasoundKnob::gain, 1.5), 10));
}

}  // namespace
}  // namespace stylet::training
