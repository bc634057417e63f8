// The machines beside the table as the trainee has set them: C-arm with its pedal, ultrasound. Set by
// commands that travel with the tools' (haptics/simulation.h), so that an attempt and its replay see the
// same.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "haptics/simulation.h"

namespace stylet::training {

enum class Machine : std::uint8_t { xray, ultrasound };

// What can be set, and how: a number in a unit that people read, whole steps of it in a command.
struct Knob {
    std::string_view name;  // in scenarios
    std::string_view word;  // typed
    std::string_view what;  // for a person
    double low = 0.0, high = 1.0;
    double step = 1.0;
};

// In the order of their numbers in commands: append, never insert.
enum class XrayKnob : std::uint8_t { rotation, angulation, field, pulses };
enum class UltrasoundKnob : std::uint8_t { transducer, depth, gain, frequency, focus, doppler, freeze, tgc0 };
inline constexpr int kTgcSliders = 8;  // tgc0 and the seven that follow it, near to far

// The command that turns it; the value is taken to the nearest step within the knob's range.
haptics::Command turn(XrayKnob, double value) noexcept;
haptics::Command turn(UltrasoundKnob, double value) noexcept;
haptics::Command turn(Machine, std::size_t knob, double value) noexcept;
std::span<const Knob> knobsOf(Machine) noexcept;

inline constexpr haptics::Command kPedalDown{haptics::CommandKind::pedal, 1};
inline constexpr haptics::Command kPedalUp{haptics::CommandKind::pedal, 0};
// Takes the rate to whole microlitres a second; 0 ends the injection.
haptics::Command injectCommand(double m3_per_s) noexcept;
inline constexpr double kMostInjected_m3_per_s = 20e-6;
inline constexpr double kMlPerM3 = 1e6;

// Trivially copyable. Angles as C-arms name them: rotation > 0 is toward the patient's left (LAO), angulation
// > 0 toward the head (cranial).
struct XrayState {
    bool pedal = false;
    double rotation_rad = 0.0, angulation_rad = 0.0;
    double field_m = 0.30;  // edge of the square that the collimator leaves open, at the detector
    double pulses_per_s = 7.5;
    std::uint64_t pulses = 0;           // so far: a picture each
    std::uint64_t last_pulse_tick = 0;  // when the last one was made
};
struct UltrasoundState {
    int transducer = 0;  // 0 convex, 1 linear
    double depth_m = 0.16, gain_db = 0.0, frequency_hz = 3.5e6, focus_m = 0.08;
    bool doppler = false, freeze = false;
    std::array<double, kTgcSliders> tgc_db{};
};
struct Machines {
    XrayState xray;
    UltrasoundState ultrasound;
    double injected_m3_per_s = 0.0;  // as asked
};

// What a command does to them; others are no concern of theirs. Unknown knobs and values out of range change
// nothing.
void take(Machines&, const haptics::Command&) noexcept;
constexpr bool isForMachines(const haptics::Command& c) noexcept {
    using haptics::CommandKind;
    return c.kind == CommandKind::inject || c.kind == CommandKind::pedal || c.kind == CommandKind::xray ||
           c.kind == CommandKind::ultrasound;
}
// The setting of a knob, as its command would have it; nothing where the command is none.
struct Turned {
    Machine machine = Machine::xray;
    std::size_t knob = 0;
    double value = 0.0;
    friend bool operator==(const Turned&, const Turned&) = default;
};
std::optional<Turned> turnedBy(const haptics::Command&) noexcept;

}  // namespace stylet::training
