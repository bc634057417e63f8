// The state of the equipment beside the table: C-arm with pedal, ultrasound machine. It is set by commands
// in the same stream as the tool commands (haptics/loop/simulation.h), so an attempt and its replay see the
// same state.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "haptics/loop/simulation.h"

namespace stylet::training {

enum class Machine : std::uint8_t { xray, ultrasound };

// A setting: a number in a readable unit. Commands carry it as a whole number of steps.
struct Knob {
    std::string_view name;  // name in scenarios
    std::string_view word;  // command as typed
    std::string_view what;  // description for the user
    double low = 0.0, high = 1.0;
    double step = 1.0;
};

// Commands contain the enumerators' numbers. Append, never insert.
enum class XrayKnob : std::uint8_t { rotation, angulation, field, pulses };
enum class UltrasoundKnob : std::uint8_t { depth, gain, frequency, focus, doppler, freeze, tgc0 };
inline constexpr int kTgcSliders = 8;  // tgc0 and the seven after it, near to far

// Command that sets a knob. The value is rounded to the nearest step and clamped to the knob's range; NaN
// gives the low end.
haptics::Command knobCommand(XrayKnob, double value) noexcept;
haptics::Command knobCommand(UltrasoundKnob, double value) noexcept;
haptics::Command knobCommand(Machine, std::size_t knob, double value) noexcept;
std::span<const Knob> machineKnobs(Machine) noexcept;

inline constexpr haptics::Command kPedalDown{haptics::CommandKind::pedal, 1};
inline constexpr haptics::Command kPedalUp{haptics::CommandKind::pedal, 0};
inline constexpr haptics::Command kAspirate{haptics::CommandKind::aspirate, 0};
inline constexpr haptics::Command kYes{haptics::CommandKind::answer, 1}, kNo{haptics::CommandKind::answer, 0};
// One syringe at a time: each of these two ends the other's injection. They round the rate to whole
// microlitres per second; 0 ends every injection.
haptics::Command injectCommand(double m3_per_s) noexcept;
haptics::Command anaesthetiseCommand(double m3_per_s) noexcept;
inline constexpr double kMaxInjectionRate_m3_per_s = 20e-6, kMaxAnaestheticRate_m3_per_s = 2e-6;
inline constexpr double kMlPerM3 = 1e6;

// Trivially copyable. Angles use the C-arm convention: rotation > 0 is toward the patient's left (LAO),
// angulation > 0 toward the head (cranial).
struct XrayState {
    bool pedal = false;
    double rotation_rad = 0.0, angulation_rad = 0.0;
    double field_m = 0.30;  // edge of the square collimator opening, at the detector
    double pulses_per_s = 7.5;
    std::uint64_t pulses = 0;           // pulse count; one picture per pulse
    std::uint64_t last_pulse_tick = 0;  // tick of the last pulse
    // The C-arm is moved over this point of the patient frame: the needle's tip when the pedal was last
    // pressed with the needle in the body. Absent: it never was.
    std::optional<Vec3> aimed_m{};
};
struct UltrasoundState {
    double depth_m = 0.16, gain_db = 0.0, frequency_hz = 3.5e6, focus_m = 0.08;
    bool doppler = false, freeze = false;
    std::array<double, kTgcSliders> tgc_db{};
};
struct Equipment {
    XrayState xray;
    UltrasoundState ultrasound;
    double injected_m3_per_s = 0.0;     // commanded rate of contrast medium
    double anaesthetic_m3_per_s = 0.0;  // commanded rate of local anaesthetic
};

// Applies a command. Ignores other commands, unknown knobs and values out of range.
void applyCommand(Equipment&, const haptics::Command&) noexcept;
constexpr bool isEquipmentCommand(const haptics::Command& c) noexcept {
    using haptics::CommandKind;
    return c.kind == CommandKind::inject || c.kind == CommandKind::pedal || c.kind == CommandKind::xray ||
           c.kind == CommandKind::ultrasound || c.kind == CommandKind::aspirate ||
           c.kind == CommandKind::anaesthetic;
}
// The knob and value in a command; nothing if the command sets no valid knob.
struct KnobSetting {
    Machine machine = Machine::xray;
    std::size_t knob = 0;
    double value = 0.0;
    friend bool operator==(const KnobSetting&, const KnobSetting&) = default;
};
std::optional<KnobSetting> decodeKnobCommand(const haptics::Command&) noexcept;

}  // namespace stylet::training
