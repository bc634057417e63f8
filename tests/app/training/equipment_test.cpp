#include "app/training/equipment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

namespace stylet::training {
namespace {

using haptics::Command;
using haptics::CommandKind;

constexpr Machine kBoth[] = {Machine::xray, Machine::ultrasound};

TEST(Knobs, CommandsEncodeEveryStepOfTheRange) {
    for (const Machine machine : kBoth)
        for (std::size_t i = 0; i < machineKnobs(machine).size(); ++i) {
            const Knob& knob = machineKnobs(machine)[i];
            for (double value = knob.low; value <= knob.high; value += 7.0 * knob.step) {
                const auto turned = decodeKnobCommand(knobCommand(machine, i, value));
                ASSERT_TRUE(turned);
                EXPECT_EQ(turned->machine, machine);
                EXPECT_EQ(turned->knob, i);
                EXPECT_NEAR(turned->value, value, 1e-9) << knob.name;
            }
        }
}

TEST(Knobs, ValuesAreClampedToTheRange) {
    const double inf = std::numeric_limits<double>::infinity();
    for (const Machine machine : kBoth)
        for (std::size_t i = 0; i < machineKnobs(machine).size(); ++i) {
            const Knob& knob = machineKnobs(machine)[i];
            EXPECT_NEAR(decodeKnobCommand(knobCommand(machine, i, inf))->value, knob.high, 1e-9) << knob.name;
            EXPECT_EQ(decodeKnobCommand(knobCommand(machine, i, -inf))->value, knob.low) << knob.name;
            EXPECT_EQ(decodeKnobCommand(knobCommand(machine, i, std::nan("")))->value, knob.low) << knob.name;
        }
}

TEST(Knobs, NamesAreUnique) {
    std::set<std::string_view> names, words;
    for (const Machine machine : kBoth)
        for (std::size_t i = 0; i < machineKnobs(machine).size(); ++i) {
            const Knob& knob = machineKnobs(machine)[i];
            EXPECT_TRUE(names.insert(knob.name).second) << knob.name;
            EXPECT_TRUE(words.insert(knob.word).second) << knob.word;
        }
}

TEST(MachinesState, CommandsAreApplied) {
    Equipment m;
    applyCommand(m, kPedalDown);
    EXPECT_TRUE(m.xray.pedal);
    applyCommand(m, kPedalUp);
    EXPECT_FALSE(m.xray.pedal);
    applyCommand(m, injectCommand(1.5e-6));
    EXPECT_NEAR(m.injected_m3_per_s, 1.5e-6, 1e-12);
    applyCommand(m, injectCommand(0.0));
    EXPECT_EQ(m.injected_m3_per_s, 0.0);
    applyCommand(m, knobCommand(XrayKnob::rotation, -30.0));
    EXPECT_NEAR(m.xray.rotation_rad, -M_PI / 6.0, 1e-9);
    applyCommand(m, knobCommand(XrayKnob::field, 180.0));
    EXPECT_NEAR(m.xray.field_m, 0.18, 1e-12);
    applyCommand(m, knobCommand(UltrasoundKnob::frequency, 5.0));
    EXPECT_NEAR(m.ultrasound.frequency_hz, 5e6, 1.0);
    applyCommand(m, knobCommand(UltrasoundKnob::doppler, 1.0));
    EXPECT_TRUE(m.ultrasound.doppler);
    applyCommand(m, knobCommand(Machine::ultrasound, std::size_t(UltrasoundKnob::tgc0) + 3, 6.5));
    EXPECT_NEAR(m.ultrasound.tgc_db[3], 6.5, 1e-9);
}

TEST(MachinesState, InvalidCommandsAreIgnored) {
    for (const double rate : {-1.0, std::nan("")})
        EXPECT_EQ(injectCommand(rate).value, 0u);
    EXPECT_EQ(injectCommand(1.0).value, 20000u);
    Equipment m;
    applyCommand(m, {CommandKind::inject, ~0u});
    EXPECT_EQ(m.injected_m3_per_s, kMaxInjectionRate_m3_per_s);
    const Equipment before = m;
    for (const Command& c :
         {Command{CommandKind::xray, ~0u}, Command{CommandKind::xray, 0x04000000u},
          Command{CommandKind::xray, 0x00ffffffu}, Command{CommandKind::ultrasound, 0xff000000u},
          Command{CommandKind::ultrasound, 0x01ffffffu}, Command{CommandKind::marker, 1},
          Command{CommandKind::tool, 3}}) {
        EXPECT_FALSE(decodeKnobCommand(c));
        applyCommand(m, c);
    }
    EXPECT_EQ(m.xray.rotation_rad, before.xray.rotation_rad);
    EXPECT_EQ(m.ultrasound.depth_m, before.ultrasound.depth_m);
}

}  // namespace
}  // namespace stylet::training
