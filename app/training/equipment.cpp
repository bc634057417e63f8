#include "app/training/equipment.h"

#include <algorithm>
#include <cmath>

namespace stylet::training {

using haptics::Command;
using haptics::CommandKind;

namespace {

constexpr double kRadPerDeg = 0.017453292519943295;
constexpr double kM3PerMicrolitre = 1e-9;

constexpr std::array kXrayKnobs{
    Knob{"rotation_deg", "rotate", "rotate the C-arm toward the patient's left, degrees", -90.0, 90.0, 0.1},
    Knob{"angulation_deg", "angulate", "angulate the C-arm toward the head, degrees", -45.0, 45.0, 0.1},
    Knob{"field_mm", "collimate", "edge length of the X-ray field at the detector, mm", 40.0, 300.0, 1.0},
    Knob{"pulses_per_s", "pulses", "X-ray pulses per second", 0.5, 30.0, 0.5},
};
constexpr std::array kUltrasoundKnobs{
    Knob{"depth_mm", "depth", "depth of the ultrasound picture, mm", 30.0, 300.0, 1.0},
    Knob{"gain_db", "gain", "gain of the ultrasound picture, dB", -40.0, 40.0, 0.5},
    Knob{"frequency_mhz", "frequency", "frequency of the probe, MHz", 1.0, 15.0, 0.1},
    Knob{"focus_mm", "focus", "focal depth of the probe, mm", 5.0, 300.0, 1.0},
    Knob{"doppler", "doppler", "1: show blood flow in colour", 0.0, 1.0, 1.0},
    Knob{"freeze", "freeze", "1: freeze the picture", 0.0, 1.0, 1.0},
    Knob{"tgc0_db", "tgc0", "gain of the first depth band (nearest the probe), dB", -20.0, 20.0, 0.5},
    Knob{"tgc1_db", "tgc1", "gain of the second depth band, dB", -20.0, 20.0, 0.5},
    Knob{"tgc2_db", "tgc2", "gain of the third depth band, dB", -20.0, 20.0, 0.5},
    Knob{"tgc3_db", "tgc3", "gain of the fourth depth band, dB", -20.0, 20.0, 0.5},
    Knob{"tgc4_db", "tgc4", "gain of the fifth depth band, dB", -20.0, 20.0, 0.5},
    Knob{"tgc5_db", "tgc5", "gain of the sixth depth band, dB", -20.0, 20.0, 0.5},
    Knob{"tgc6_db", "tgc6", "gain of the seventh depth band, dB", -20.0, 20.0, 0.5},
    Knob{"tgc7_db", "tgc7", "gain of the last depth band (furthest), dB", -20.0, 20.0, 0.5},
};
static_assert(kUltrasoundKnobs.size() == std::size_t(UltrasoundKnob::tgc0) + kTgcSliders);

// A command's value: the knob's number in the high bits, the number of steps from the knob's low end in the
// low bits.
constexpr int kKnobShift = 24;
constexpr std::uint32_t kStepsMask = (1u << kKnobShift) - 1;

double stepsOf(const Knob& knob) noexcept {
    return std::floor((knob.high - knob.low) / knob.step + 0.5);
}

std::uint32_t microlitresPerS(double m3_per_s, double most_m3_per_s) noexcept {
    const double rate = m3_per_s > 0.0 ? std::min(m3_per_s, most_m3_per_s) : 0.0;
    return std::uint32_t(std::floor(rate / kM3PerMicrolitre + 0.5));
}

void set(XrayState& xray, XrayKnob knob, double value) noexcept {
    if (knob == XrayKnob::rotation) xray.rotation_rad = value * kRadPerDeg;
    if (knob == XrayKnob::angulation) xray.angulation_rad = value * kRadPerDeg;
    if (knob == XrayKnob::field) xray.field_m = value / 1000.0;
    if (knob == XrayKnob::pulses) xray.pulses_per_s = value;
}

void set(UltrasoundState& u, UltrasoundKnob knob, double value) noexcept {
    if (knob == UltrasoundKnob::depth) u.depth_m = value / 1000.0;
    if (knob == UltrasoundKnob::gain) u.gain_db = value;
    if (knob == UltrasoundKnob::frequency) u.frequency_hz = value * 1e6;
    if (knob == UltrasoundKnob::focus) u.focus_m = value / 1000.0;
    if (knob == UltrasoundKnob::doppler) u.doppler = value != 0.0;
    if (knob == UltrasoundKnob::freeze) u.freeze = value != 0.0;
    if (knob >= UltrasoundKnob::tgc0) u.tgc_db[std::size_t(knob) - std::size_t(UltrasoundKnob::tgc0)] = value;
}

}  // namespace

std::span<const Knob> machineKnobs(Machine machine) noexcept {
    if (machine == Machine::xray) return kXrayKnobs;
    return kUltrasoundKnobs;
}

Command knobCommand(Machine machine, std::size_t number, double value) noexcept {
    const Knob& knob = machineKnobs(machine)[number];
    const double steps =
        std::isnan(value) ? 0.0
                          : std::clamp(std::floor((value - knob.low) / knob.step + 0.5), 0.0, stepsOf(knob));
    return {machine == Machine::xray ? CommandKind::xray : CommandKind::ultrasound,
            std::uint32_t(number) << kKnobShift | std::uint32_t(steps)};
}
Command knobCommand(XrayKnob knob, double value) noexcept {
    return knobCommand(Machine::xray, std::size_t(knob), value);
}
Command knobCommand(UltrasoundKnob knob, double value) noexcept {
    return knobCommand(Machine::ultrasound, std::size_t(knob), value);
}

Command injectCommand(double m3_per_s) noexcept {
    return {CommandKind::inject, microlitresPerS(m3_per_s, kMaxInjectionRate_m3_per_s)};
}
Command anaesthetiseCommand(double m3_per_s) noexcept {
    return {CommandKind::anaesthetic, microlitresPerS(m3_per_s, kMaxAnaestheticRate_m3_per_s)};
}

std::optional<KnobSetting> decodeKnobCommand(const Command& c) noexcept {
    if (c.kind != CommandKind::xray && c.kind != CommandKind::ultrasound) return std::nullopt;
    const Machine machine = c.kind == CommandKind::xray ? Machine::xray : Machine::ultrasound;
    const std::size_t number = c.value >> kKnobShift;
    if (number >= machineKnobs(machine).size()) return std::nullopt;
    const Knob& knob = machineKnobs(machine)[number];
    const auto steps = double(c.value & kStepsMask);
    if (steps > stepsOf(knob)) return std::nullopt;
    return KnobSetting{machine, number, knob.low + steps * knob.step};
}

void applyCommand(Equipment& equipment, const Command& c) noexcept {
    if (c.kind == CommandKind::inject || c.kind == CommandKind::anaesthetic) {
        const double m3_per_s = double(c.value) * kM3PerMicrolitre;
        const bool contrast = c.kind == CommandKind::inject;
        equipment.injected_m3_per_s = contrast ? std::min(m3_per_s, kMaxInjectionRate_m3_per_s) : 0.0;
        equipment.anaesthetic_m3_per_s = contrast ? 0.0 : std::min(m3_per_s, kMaxAnaestheticRate_m3_per_s);
    }
    if (c.kind == CommandKind::pedal) equipment.xray.pedal = c.value != 0;
    const std::optional<KnobSetting> setting = decodeKnobCommand(c);
    if (!setting) return;
    if (setting->machine == Machine::xray)
        set(equipment.xray, XrayKnob(setting->knob), setting->value);
    else
        set(equipment.ultrasound, UltrasoundKnob(setting->knob), setting->value);
}

}  // namespace stylet::training
