#include "app/training/machines.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace stylet::training {
namespace {

using haptics::Command;
using haptics::CommandKind;

constexpr Machine kBoth[] = {Machine::xray, Machine::ultrasound};

TEST(Knobs, HoldEveryStepOfTheirRangeInACommand) {
    for (const Machine machine : kBoth)
        for (std::size_t i = 0; i < knobsOf(machine).size(); ++i) {
            const Knob& knob = knobsOf(machine)[i];
            for (double value = knob.low; value <= knob.high; value += 7.0 * knob.step) {
                const auto turned = turnedBy(turn(machine, i, value));
                ASSERT_TRUE(turned);
                EXPECT_EQ(turned->machine, machine);
                EXPECT_EQ(turned->knob, i);
                EXPECT_NEAR(turned->value, value, 1e-9) << knob.name;
            }
        }
}

TEST(Knobs, KeepToTheirRange) {
    const double inf = std::numeric_limits<double>::infinity();
    for (const Machine machine : kBoth)
        for (std::size_t i = 0; i < knobsOf(machine).size(); ++i) {
            const Knob& knob = knobsOf(machine)[i];
            EXPECT_NEAR(turnedBy(turn(machine, i, inf))->value, knob.high, 1e-9) << knob.name;
            EXPECT_EQ(turnedBy(turn(machine, i, -inf))->value, knob.low) << knob.name;
            EXPECT_EQ(turnedBy(turn(machine, i, std::nan("")))->value, knob.low) << knob.name;
        }
}

TEST(Knobs, HaveNamesOfTheirOwn) {
    std::set<std::string_view> names, words;
    for (const Machine machine : kBoth)
        for (std::size_t i = 0; i < knobsOf(machine).size(); ++i) {
            const Knob& knob = knobsOf(machine)[i];
            EXPECT_TRUE(names.insert(knob.name).second) << knob.name;
            EXPECT_TRUE(words.insert(knob.word).second) << knob.word;
        }
}

TEST(MachinesState, TakesItsCommands) {
    Machines m;
    take(m, kPedalDown);
    EXPECT_TRUE(m.xray.pedal);
    take(m, kPedalUp);
    EXPECT_FALSE(m.xray.pedal);
    take(m, injectCommand(1.5e-6));
    EXPECT_NEAR(m.injected_m3_per_s, 1.5e-6, 1e-12);
    take(m, injectCommand(0.0));
    EXPECT_EQ(m.injected_m3_per_s, 0.0);
    take(m, turn(XrayKnob::rotation, -30.0));
    EXPECT_NEAR(m.xray.rotation_rad, -M_PI / 6.0, 1e-9);
    take(m, turn(XrayKnob::field, 180.0));
    EXPECT_NEAR(m.xray.field_m, 0.18, 1e-12);
    take(m, turn(UltrasoundKnob::frequency, 5.0));
    EXPECT_NEAR(m.ultrasound.frequency_hz, 5e6, 1.0);
    take(m, turn(UltrasoundKnob::doppler, 1.0));
    EXPECT_TRUE(m.ultrasound.doppler);
    take(m, turn(Machine::ultrasound, std::size_t(UltrasoundKnob::tgc0) + 3, 6.5));
    EXPECT_NEAR(m.ultrasound.tgc_db[3], 6.5, 1e-9);
}

TEST(MachinesState, LetsNonsensePass) {
    for (const double rate : {-1.0, std::nan("")})
        EXPECT_EQ(injectCommand(rate).value, 0u);
    EXPECT_EQ(injectCommand(1.0).value, 20000u);
    Machines m;
    take(m, {CommandKind::inject, ~0u});
    EXPECT_EQ(m.injected_m3_per_s, kMostInjected_m3_per_s);
    const Machines before = m;
    for (const Command& c :
         {Command{CommandKind::xray, ~0u}, Command{CommandKind::xray, 0x04000000u},
          Command{CommandKind::xray, 0x00ffffffu}, Command{CommandKind::ultrasound, 0xff000000u},
          Command{CommandKind::ultrasound, 0x01ffffffu}, Command{CommandKind::marker, 1},
          Command{CommandKind::tool, 3}}) {
        EXPECT_FALSE(turnedBy(c));
        take(m, c);
    }
    EXPECT_EQ(m.xray.rotation_rad, before.xray.rotation_rad);
    EXPECT_EQ(m.ultrasound.depth_m, before.ultrasound.depth_m);
}

}  // namespace
}  // namespace stylet::training
