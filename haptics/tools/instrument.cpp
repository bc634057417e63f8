#include "haptics/tools/instrument.h"

#include <fmt/core.h>
#include <algorithm>

#include "base/fields.h"
#include "base/hash.h"
#include "base/text.h"
#include "base/whole_file.h"

namespace stylet::haptics {

namespace {

constexpr std::size_t kMaxInstrumentBytes = 1 << 16, kMaxTitleBytes = 100;
constexpr double kMmPerM = 1e3, kRadPerDeg = 0.017453292519943295, kNMm2PerNM2 = 1e6;

struct Limits {
    double low, high;
};
constexpr Limits kOuter_mm{0.1, 10.0}, kLength_mm{10.0, 2000.0}, kBevel_deg{5.0, 80.0}, kMark_mm{1.0, 500.0},
    kEcho{0.0, 1.0}, kAttenuation_per_m{0.0, 5000.0};

bool within(double value, const Limits& limits, double unit = 1.0) {
    // The unit's rounding must not refuse a value at a limit.
    return value / unit >= limits.low * (1.0 - 1e-9) && value / unit <= limits.high * (1.0 + 1e-9);
}

double readMm(Fields& in, std::string_view key, const Limits& limits) {
    return in.number(key, limits.low, limits.high) / kMmPerM;
}

void readMarks(Fields in, NeedleShape& shape) {
    shape.first_mark_m = readMm(in, "first_mm", kMark_mm);
    shape.mark_step_m = readMm(in, "every_mm", kMark_mm);
    in.finish();
}

void readMaterial(Fields in, NeedleShape& shape) {
    shape.attenuation_per_m = in.number("attenuation_per_m", kAttenuation_per_m.low, kAttenuation_per_m.high);
    shape.shaft_echo = in.number("shaft_echo", kEcho.low, kEcho.high);
    shape.tip_echo = in.number("tip_echo", kEcho.low, kEcho.high);
    in.finish();
}

NeedleTip readTip(Fields in, NeedleShape& shape) {
    shape.bevel_rad = in.number("bevel_deg", kBevel_deg.low, kBevel_deg.high) * kRadPerDeg;
    const auto tip = in.choice<NeedleTip>("kind", kNeedleTipNames);
    in.finish();
    return tip;
}

// Dimensions and material of a needle or of another tool with a shaft.
NeedleShape readShape(Fields& top, bool needle) {
    NeedleShape shape;
    Fields shaft = top.child("shaft");
    shape.outer_m = readMm(shaft, "outer_mm", kOuter_mm);
    shape.inner_m = readMm(shaft, "inner_mm", {0.0, kOuter_mm.high});
    if (shape.inner_m >= shape.outer_m) shaft.refuse("inner_mm", "not below outer_mm");
    shape.length_m = readMm(shaft, "length_mm", kLength_mm);
    shape.has_stylet = needle && shaft.flag("stylet");
    shaft.finish();
    shape.mark_step_m = 0.0;
    if (top.has("marks")) readMarks(top.child("marks"), shape);
    readMaterial(top.child("material"), shape);
    if (needle) {
        shape.tip = readTip(top.child("tip"), shape);
        if (const std::string why = shapeError(shape); !why.empty()) top.refuse("tip", why);
    }
    return shape;
}

// `a1_share` and `max_force_n` belong to the model; instrument files do not set them.
NeedleSettings readNeedleForce(Fields in, const NeedleShape& shape) {
    NeedleSettings s;
    s.cut_reach_m = in.has("cut_reach_mm") ? readMm(in, "cut_reach_mm", kOuter_mm) : shape.outer_m;
    s.friction_scale =
        in.numberOr("friction_scale", kMinFrictionScale, kMaxFrictionScale, shape.outer_m / kPaperNeedle_m);
    s.lateral_stiffness_n_per_m = in.number("lateral_stiffness_n_per_m", 1.0, 5000.0);
    s.lateral_force_n = in.number("lateral_force_n", 0.01, 20.0);
    if (s.cut_reach_m > 10.0 * shape.outer_m)
        in.refuse("cut_reach_mm", fmt::format("more than ten times outer_mm, {}", shape.outer_m * kMmPerM));
    in.finish();
    return s;
}

PadSettings readPad(Fields in) {
    PadSettings pad;
    pad.max_stiffness_n_per_m = in.number("max_stiffness_n_per_m", 1.0, 10000.0);
    pad.shear_n_per_m = in.number("shear_n_per_m", 0.0, 10000.0);
    pad.friction = in.number("friction", 0.0, 2.0);
    in.finish();
    return pad;
}

FingerSettings readFinger(Fields& top) {
    FingerSettings s;
    Fields face = top.child("face");
    s.points = int(face.integer("points", 7, 30));
    s.radius_m = readMm(face, "radius_mm", {1.0, 30.0});
    s.curvature_m = readMm(face, "curvature_mm", {1.0, 1000.0});
    face.finish();
    if (s.curvature_m < s.radius_m) top.refuse("face", "curvature_mm is below radius_mm");
    s.pad = readPad(top.child("force"));
    return s;
}

ProbeSettings readProbe(Fields& top) {
    ProbeSettings s;
    Fields face = top.child("face");
    s.columns = int(face.integer("columns", 2, kMaxPadPoints));
    s.rows = int(face.integer("rows", 1, kMaxPadPoints));
    if (s.columns * s.rows > kMaxPadPoints)
        face.refuse("rows", fmt::format("more than {} points with these columns", kMaxPadPoints));
    s.length_m = readMm(face, "length_mm", {5.0, 200.0});
    s.width_m = readMm(face, "width_mm", {1.0, 100.0});
    s.curvature_m = readMm(face, "curvature_mm", {5.0, 100'000.0});
    face.finish();
    if (2.0 * s.curvature_m < s.length_m) top.refuse("face", "curvature_mm is below half of length_mm");
    s.pad = readPad(top.child("force"));
    return s;
}

ScalpelSettings readScalpel(Fields in) {
    ScalpelSettings s;
    s.stiffness_n_per_m = in.number("stiffness_n_per_m", 1.0, 10000.0);
    s.cut_force_n = in.number("cut_force_n", 0.01, 20.0);
    s.friction = in.number("friction", 0.0, 2.0);
    s.deeper_n = in.number("deeper_n", 0.01, 20.0);
    s.along_edge_n = in.number("along_edge_n", 0.01, 20.0);
    s.across_blade_n = in.number("across_blade_n", 0.01, 20.0);
    s.width_per_depth = in.number("width_per_depth", 0.01, 10.0);
    s.open_reach_m = readMm(in, "open_reach_mm", kOuter_mm);
    in.finish();
    return s;
}

WireSettings readWire(Fields in, const NeedleShape& shape) {
    WireSettings s;
    s.outer_m = shape.outer_m;
    s.attenuation_per_m = shape.attenuation_per_m;
    s.tip_length_m = readMm(in, "tip_length_mm", {8.0, 160.0});
    s.tip_stiffness_n_m2 = in.number("tip_stiffness_n_mm2", 0.01, 10'000.0) / kNMm2PerNM2;
    s.shaft_stiffness_n_m2 = in.number("shaft_stiffness_n_mm2", 0.01, 10'000.0) / kNMm2PerNM2;
    s.grip_n_per_m = in.number("grip_n_per_m", 10.0, 2000.0);
    s.bore_friction_n = in.number("bore_friction_n", 0.0, 5.0);
    s.drag_n_per_m = in.number("drag_n_per_m", 0.0, 100.0);
    s.friction = in.number("friction", 0.0, 1.0);
    s.tip_friction = in.number("tip_friction", 0.0, 2.0);
    s.blunt_n = in.number("blunt_n", 0.1, 20.0);
    in.finish();
    return s;
}

TubeSettings readTube(Fields in, const NeedleShape& shape, bool drain) {
    TubeSettings s;
    s.outer_m = shape.outer_m, s.inner_m = shape.inner_m;
    s.attenuation_per_m = shape.attenuation_per_m;
    s.taper_m = readMm(in, "taper_mm", {1.0, 100.0});
    s.stiffness_n_per_m = in.number("stiffness_n_per_m", 10.0, 2000.0);
    s.blunt_n = in.number("blunt_n", 0.1, 20.0);
    if (drain) s.pigtail_m = readMm(in, "pigtail_mm", {5.0, 30.0});
    in.finish();
    return s;
}

void hashForce(StateHash& hash, const NeedleSettings& s) {
    hash.add(s.a1_share, s.cut_reach_m, s.max_force_n, s.friction_scale);
    hash.add(s.lateral_stiffness_n_per_m, s.lateral_force_n);
}
void hashForce(StateHash& hash, const PadSettings& s) {
    hash.add(s.max_stiffness_n_per_m, s.shear_n_per_m, s.friction);
}
void hashForce(StateHash& hash, const FingerSettings& s) {
    hash.add(std::uint64_t(s.points));
    hash.add(s.radius_m, s.curvature_m);
    hashForce(hash, s.pad);
}
void hashForce(StateHash& hash, const ProbeSettings& s) {
    hash.add(std::uint64_t(s.columns) | std::uint64_t(s.rows) << 32);
    hash.add(s.length_m, s.width_m, s.curvature_m);
    hashForce(hash, s.pad);
}
void hashForce(StateHash& hash, const ScalpelSettings& s) {
    hash.add(s.stiffness_n_per_m, s.cut_force_n, s.friction, s.deeper_n);
    hash.add(s.along_edge_n, s.across_blade_n, s.width_per_depth, s.open_reach_m);
}
void hashForce(StateHash& hash, const WireSettings& s) {
    visitWireNumbers(s, [&](double v) { hash.add(v); });
}
void hashForce(StateHash& hash, const TubeSettings& s) {
    visitTubeNumbers(s, [&](double v) { hash.add(v); });
}
void hashForce(StateHash&, std::monostate) {}

}  // namespace

Instrument loadInstrument(const std::filesystem::path& toml) {
    return parseInstrument(toml, readWholeFile(toml, kMaxInstrumentBytes));
}

Instrument parseInstrument(const std::filesystem::path& toml, std::string_view text) {
    Fields top = parseToml(toml, text);
    Instrument one;
    one.name = toml.stem().string();
    one.title = top.nonEmptyText("title", kMaxTitleBytes);
    one.kind = top.choice<InstrumentKind>("kind", kInstrumentKindNames);
    one.gauge = 0;
    one.force = std::monostate();
    switch (one.kind) {
        case InstrumentKind::needle:
            one.gauge = int(top.integer("gauge", kMinGauge, kMaxGauge));
            one.shape = readShape(top, true);
            one.force = readNeedleForce(top.child("force"), one.shape);
            break;
        case InstrumentKind::scalpel:
            one.force = readScalpel(top.child("force"));
            break;
        case InstrumentKind::probe:
            one.transducer = top.nonEmptyText("transducer", kMaxTitleBytes);
            if (one.transducer.find('/') != std::string::npos) top.refuse("transducer", "is no name");
            one.force = readProbe(top);
            break;
        case InstrumentKind::finger:
            one.force = readFinger(top);
            break;
        case InstrumentKind::guideWire:
            one.shape = readShape(top, false);
            one.force = readWire(top.child("force"), one.shape);
            break;
        case InstrumentKind::dilator:
        case InstrumentKind::drain:
            one.shape = readShape(top, false);
            one.force = readTube(top.child("force"), one.shape, one.kind == InstrumentKind::drain);
            break;
    }
    top.finish();
    return one;
}

std::vector<Instrument> loadInstruments(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".toml") files.push_back(entry.path());
    std::ranges::sort(files);
    std::vector<Instrument> all;
    for (const std::filesystem::path& file : files)
        all.push_back(loadInstrument(file));
    return all;
}

NeedleShape tubeShape(double outer_mm, double inner_mm, double length_mm, double attenuation_per_m) noexcept {
    NeedleShape shape;
    shape.outer_m = outer_mm / kMmPerM, shape.inner_m = inner_mm / kMmPerM;
    shape.length_m = length_mm / kMmPerM;
    shape.attenuation_per_m = attenuation_per_m;
    shape.has_stylet = false;
    shape.mark_step_m = 0.0;
    shape.shaft_echo = shape.tip_echo = 0.02;
    return shape;
}

Instrument* findInstrument(InstrumentSet& set, InstrumentKind kind) noexcept {
    Instrument* found = nullptr;
    visitInstruments(set, [&](Instrument& one) {
        if (one.kind == kind) found = &one;
    });
    return found;
}

std::string shapeError(const NeedleShape& s) {
    if (!within(s.outer_m, kOuter_mm, 1e-3)) return "its outer diameter is out of range";
    if (!(s.inner_m >= 0.0 && s.inner_m < s.outer_m)) return "its inner diameter is not below the outer one";
    if (!within(s.length_m, kLength_mm, 1e-3)) return "its length is out of range";
    if (!within(s.bevel_rad, kBevel_deg, kRadPerDeg)) return "its bevel is out of range";
    if (s.mark_step_m != 0.0 &&
        !(within(s.mark_step_m, kMark_mm, 1e-3) && within(s.first_mark_m, kMark_mm, 1e-3)))
        return "its marks are out of range";
    if (!within(s.shaft_echo, kEcho) || !within(s.tip_echo, kEcho)) return "its echo is out of range";
    if (!within(s.attenuation_per_m, kAttenuation_per_m)) return "its attenuation is out of range";
    if (!(s.tipLength_m() < s.length_m)) return "its tip is longer than the needle";
    return "";
}

std::uint64_t digest(const Instrument& one) {
    StateHash hash;
    hash.add(std::string_view(one.name));
    hash.add(std::string_view(one.title));
    hash.add(std::string_view(one.transducer));
    hash.add(std::uint64_t(one.kind) | std::uint64_t(one.gauge) << 8 | std::uint64_t(one.shape.tip) << 16 |
             std::uint64_t(one.shape.has_stylet) << 24);
    visitShapeNumbers(one.shape, [&](double v) { hash.add(v); });
    std::visit([&](const auto& settings) { hashForce(hash, settings); }, one.force);
    return hash.value();
}

std::string describe(const Instrument& one) {
    std::string line = fmt::format("{:<14} {}", one.name, one.title);
    const NeedleShape& s = one.shape;
    if (one.kind == InstrumentKind::needle)
        line +=
            fmt::format(": {} G, {:.3g} mm x {:.3g} mm, {} tip of {:.1f} mm", one.gauge, s.outer_m * kMmPerM,
                        s.length_m * kMmPerM, enumName(kNeedleTipNames, s.tip), s.tipLength_m() * kMmPerM);
    else if (std::holds_alternative<WireSettings>(one.force) ||
             std::holds_alternative<TubeSettings>(one.force))
        line += fmt::format(": {:.3g} mm x {:.3g} mm", s.outer_m * kMmPerM, s.length_m * kMmPerM);
    return line;
}

}  // namespace stylet::haptics
