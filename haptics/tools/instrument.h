// Instruments: one file each in assets/instruments, whose README.md documents the fields. An instrument is
// the only source of a tool's dimensions, material and force settings.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/needle_shape.h"
#include "haptics/tools/finger.h"
#include "haptics/tools/needle.h"
#include "haptics/tools/probe.h"
#include "haptics/tools/scalpel.h"

namespace stylet::haptics {

// Guide wire, dilator and drain are data only: no tool uses them yet.
enum class InstrumentKind : std::uint8_t { needle, scalpel, probe, finger, guideWire, dilator, drain };
inline constexpr std::array<std::string_view, 7> kInstrumentKindNames{
    "needle", "scalpel", "probe", "finger", "guide wire", "dilator", "drain"};
inline constexpr std::array<std::string_view, 3> kNeedleTipNames{"chiba", "trocar", "diamond"};

inline constexpr std::string_view kDefaultNeedle = "needle-17g";
// Outer diameter of the needle on which the friction of the force table was measured (Mastmeyer et al. 2017).
inline constexpr double kPaperNeedle_m = 0.0015;

// The default instrument is the default needle.
struct Instrument {
    std::string name{kDefaultNeedle};  // the file's name without .toml
    std::string title = "17 G PTCD needle";
    InstrumentKind kind = InstrumentKind::needle;
    int gauge = 17;          // needles only
    NeedleShape shape;       // needle, guide wire, dilator, drain
    std::string transducer;  // probe: name of its file in assets/ultrasound
    // Settings of the tool's force: those of `kind`, none for a kind that is data only.
    std::variant<std::monostate, NeedleSettings, ScalpelSettings, ProbeSettings, FingerSettings> force =
        NeedleSettings{};
};

// All throw DataError with file, field and reason.
Instrument loadInstrument(const std::filesystem::path& toml);
// As loadInstrument(), from the text of the file `toml`.
Instrument parseInstrument(const std::filesystem::path& toml, std::string_view text);
// Every instrument in a folder, by name.
std::vector<Instrument> loadInstruments(const std::filesystem::path& folder);

// Reason why no needle has this shape, or an empty string. Used for shapes that do not come from
// parseInstrument(), which checks the same limits.
std::string shapeError(const NeedleShape&);
// The needle's tip as a number is within the enumeration.
inline constexpr int kMinGauge = 7, kMaxGauge = 34;
inline constexpr double kMinFrictionScale = 0.01, kMaxFrictionScale = 10.0;
constexpr bool isGauge(int gauge) noexcept {
    return gauge >= kMinGauge && gauge <= kMaxGauge;
}
// False for NaN.
constexpr bool isFrictionScale(double scale) noexcept {
    return scale >= kMinFrictionScale && scale <= kMaxFrictionScale;
}
constexpr bool isNeedleTip(std::uint32_t tip) noexcept {
    return tip < kNeedleTipNames.size();
}

// 64-bit hash of all values.
std::uint64_t digest(const Instrument&);
// One line for the user: name, title and the main numbers.
std::string describe(const Instrument&);

}  // namespace stylet::haptics
