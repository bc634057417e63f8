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
#include "haptics/tools/tube.h"
#include "haptics/tools/wire.h"

namespace stylet::haptics {

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
    int gauge = 17;            // needles only
    NeedleShape shape{};       // needle, guide wire, dilator, drain
    std::string transducer{};  // probe: name of its file in assets/ultrasound
    // Settings of the tool's force: those of `kind`.
    std::variant<std::monostate, NeedleSettings, ScalpelSettings, ProbeSettings, FingerSettings, WireSettings,
                 TubeSettings>
        force = NeedleSettings{};
};

// Shape of a wire or tube, without marks or stylet.
NeedleShape tubeShape(double outer_mm, double inner_mm, double length_mm, double attenuation_per_m) noexcept;
// True for the kinds with a shaft.
constexpr bool hasShape(InstrumentKind kind) noexcept {
    return kind == InstrumentKind::needle || kind >= InstrumentKind::guideWire;
}

// The instruments of an attempt, one of each kind. By default each kind's default instrument.
struct InstrumentSet {
    Instrument needle;
    Instrument scalpel{.name = "scalpel",
                       .title = "scalpel, No. 11 blade",
                       .kind = InstrumentKind::scalpel,
                       .gauge = 0,
                       .force = ScalpelSettings{}};
    Instrument probe{.name = "probe-convex",
                     .title = "convex ultrasound probe",
                     .kind = InstrumentKind::probe,
                     .gauge = 0,
                     .transducer = "convex",
                     .force = ProbeSettings{}};
    Instrument finger{.name = "finger",
                      .title = "palpating finger",
                      .kind = InstrumentKind::finger,
                      .gauge = 0,
                      .force = FingerSettings{}};
    Instrument wire{.name = "guide-wire",
                    .title = "0.035 in guide wire",
                    .kind = InstrumentKind::guideWire,
                    .gauge = 0,
                    .shape = tubeShape(0.89, 0.0, 800.0, 652.0),
                    .force = WireSettings{}};
    Instrument dilator{.name = "dilator",
                       .title = "8 F dilator",
                       .kind = InstrumentKind::dilator,
                       .gauge = 0,
                       .shape = tubeShape(2.67, 0.97, 200.0, 21.8),
                       .force = TubeSettings{}};
    Instrument drain{.name = "drain",
                     .title = "8.5 F biliary drain",
                     .kind = InstrumentKind::drain,
                     .gauge = 0,
                     .shape = tubeShape(2.83, 1.7, 400.0, 150.0),
                     .force = kDrainDefaults};
};
// Calls `visit` for every instrument, in a fixed order.
template <typename Set, typename Visit>
void visitInstruments(Set& set, const Visit& visit) {
    visit(set.needle), visit(set.scalpel), visit(set.probe), visit(set.finger);
    visit(set.wire), visit(set.dilator), visit(set.drain);
}
// The set's instrument of a kind.
Instrument* findInstrument(InstrumentSet&, InstrumentKind) noexcept;

// All throw DataError with file, field and reason.
Instrument loadInstrument(const std::filesystem::path& toml);
// As loadInstrument(), from the text of the file `toml`.
Instrument parseInstrument(const std::filesystem::path& toml, std::string_view text);
// Every instrument in a folder, by name.
std::vector<Instrument> loadInstruments(const std::filesystem::path& folder);

// Reason why no needle has this shape, or an empty string. Used for shapes that do not come from
// parseInstrument(), which checks the same limits.
std::string shapeError(const NeedleShape&);
inline constexpr int kMinGauge = 7, kMaxGauge = 34;
inline constexpr double kMinFrictionScale = 0.01, kMaxFrictionScale = 10.0;
constexpr bool isGauge(int gauge) noexcept {
    return gauge >= kMinGauge && gauge <= kMaxGauge;
}
// False for NaN.
constexpr bool isFrictionScale(double scale) noexcept {
    return scale >= kMinFrictionScale && scale <= kMaxFrictionScale;
}
// True if `tip` is an enumerator of NeedleTip.
constexpr bool isNeedleTip(std::uint32_t tip) noexcept {
    return tip < kNeedleTipNames.size();
}

// 64-bit hash of all values.
std::uint64_t digest(const Instrument&);
// One line for the user: name, title and the main numbers.
std::string describe(const Instrument&);

}  // namespace stylet::haptics
