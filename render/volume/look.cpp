#include "render/volume/look.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/fields.h"
#include "base/whole_file.h"

namespace stylet::render {
namespace {

using std::filesystem::path;

constexpr std::size_t kMaxLookBytes = 1 << 20, kMaxLookRows = 10'000;
constexpr double kPerMm = 1000.0;

float linearFromSrgb(int byte) {
    const double c = byte / 255.0;
    return float(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

glm::vec3 linearFromSrgb(const std::array<std::uint8_t, 3>& c) {
    return {linearFromSrgb(c[0]), linearFromSrgb(c[1]), linearFromSrgb(c[2])};
}

glm::vec3 readColour(Fields& in, std::string_view key) {
    const std::string text = in.text(key);
    const bool hex =
        text.size() == 7 && text[0] == '#' &&
        std::all_of(text.begin() + 1, text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
    if (!hex) in.refuse(key, "'" + text + "' is not an sRGB colour like \"#e0c0a0\"");
    const auto byte = [&](std::size_t at) {
        return std::uint8_t(std::stoi(text.substr(at, 2), nullptr, 16));
    };
    return linearFromSrgb(std::array{byte(1), byte(3), byte(5)});
}

std::vector<HuPoint> readCurve(Fields& root) {
    std::vector<HuPoint> points;
    for (Fields& in : root.childrenOrNone("hu", kMaxLookRows)) {
        HuPoint point;
        point.hu = in.number("hu", -2000.0, 10000.0);
        point.extinction_per_m = kPerMm * in.number("extinction_per_mm", 0.0, 1000.0);
        point.colour_linear = readColour(in, "colour");
        if (!points.empty() && point.hu <= points.back().hu) in.refuse("hu", "not ascending");
        points.push_back(point);
    }
    if (points.empty()) root.refuse("hu", "at least one [[hu]] point is needed");
    return points;
}

LookRule readLookRule(Fields& in) {
    LookRule rule;
    readLabelRule(in, rule);
    if (in.has("extinction_per_mm"))
        rule.extinction_per_m = kPerMm * in.number("extinction_per_mm", 0.0, 1000.0);
    if (in.has("shell_per_mm")) rule.shell_per_m = kPerMm * in.number("shell_per_mm", 0.0, 1000.0);
    if (in.has("colour")) rule.colour_linear = readColour(in, "colour");
    return rule;
}

void readSurface(Fields in, LookStyle& look) {
    look.wrap = float(in.number("wrap", 0.0, 1.0));
    look.specular = float(in.number("specular", 0.0, 4.0));
    look.specular_power = float(in.number("specular_power", 0.0, 1000.0));
    look.rim = float(in.number("rim", 0.0, 4.0));
    look.gradient_voxels = float(in.number("gradient_voxels", 0.0, 4.0));
    look.smoothing_voxels = int(in.number("smoothing_voxels", 0.0, 6.0));
    look.edge_low = float(in.number("edge_low", 0.0, 0.9));
    look.edge_high = float(in.number("edge_high", 0.0, 1.0));
    if (look.edge_low >= look.edge_high) in.refuse("edge_high", "not above edge_low");
    look.mottle = float(in.numberOr("mottle", 0.0, 1.0, 0.0));
    look.pores = float(in.numberOr("pores", 0.0, 1.0, 0.0));
    look.grazing_tint = readColour(in, "grazing_tint");
}

glm::vec4 stored(const glm::vec3& colour_linear, double extinction_per_m, double full_per_m) {
    const float a = float(std::sqrt(extinction_per_m / full_per_m));
    return {std::sqrt(colour_linear.r) * a, std::sqrt(colour_linear.g) * a, std::sqrt(colour_linear.b) * a,
            a};
}

// Linear between points in the stored form. Samples are interpolated in that form too, so a ramp over
// partial-volume values stays linear.
glm::vec4 curveAt(const LookStyle& look, double hu) {
    const auto& points = look.hu;
    const auto value = [&](const HuPoint& p) {
        return stored(p.colour_linear, p.extinction_per_m, look.full_extinction_per_m);
    };
    const auto above =
        std::find_if(points.begin(), points.end(), [&](const HuPoint& p) { return p.hu > hu; });
    if (above == points.begin()) return value(points.front());
    if (above == points.end()) return value(points.back());
    const HuPoint &a = *(above - 1), &b = *above;
    return glm::mix(value(a), value(b), float((hu - a.hu) / (b.hu - a.hu)));
}

}  // namespace

LookStyle loadLook(const path& file) {
    return parseLook(file, readWholeFile(file, kMaxLookBytes));
}

LookStyle parseLook(const path& file, std::string_view text) {
    LookStyle look;
    Fields root = parseToml(file, text);
    look.name = root.textOr("name", file.stem().string());
    look.hu = readCurve(root);
    for (Fields& rule : root.childrenOrNone("rule", kMaxLookRows))
        look.rules.push_back(readLookRule(rule));
    readSurface(root.childOrEmpty("surface"), look);
    double full = 0.0;
    for (const HuPoint& p : look.hu)
        full = std::max(full, p.extinction_per_m);
    for (const LookRule& r : look.rules)
        full = std::max(full, r.extinction_per_m.value_or(0.0));
    if (full <= 0.0) throw DataError(file, "extinction_per_mm", "nothing would be visible");
    look.full_extinction_per_m = full;
    return look;
}

Palette makePalette(const LookStyle& look, const patient::Patient& patient) {
    Palette palette;
    palette.smoothing_voxels = look.smoothing_voxels;
    palette.edge_low = look.edge_low;
    palette.edge_high = look.edge_high;
    palette.hu.reserve(std::size_t(Palette::kHuEnd - Palette::kHuBegin));
    for (int hu = Palette::kHuBegin; hu < Palette::kHuEnd; ++hu)
        palette.hu.push_back(curveAt(look, hu));
    palette.follows_hu.fill(true);
    palette.label.fill(glm::vec4(-1.0f));  // negative: the curve's own colour
    for (int id = 1; id < 256; ++id) {
        const patient::Label* label = patient.label(std::uint8_t(id));
        if (!label) continue;
        const auto rule = std::find_if(look.rules.begin(), look.rules.end(),
                                       [&](const LookRule& r) { return r.matches(*label); });
        if (rule == look.rules.end()) continue;
        const glm::vec3 colour = rule->colour_linear.value_or(linearFromSrgb(label->colour));
        palette.follows_hu[std::size_t(id)] = !rule->extinction_per_m;
        if (rule->shell_per_m)
            palette.shell[std::size_t(id)] = stored(colour, *rule->shell_per_m, look.full_extinction_per_m);
        palette.label[std::size_t(id)] = stored(
            colour, rule->extinction_per_m.value_or(look.full_extinction_per_m), look.full_extinction_per_m);
    }
    return palette;
}

glm::vec4 Palette::at(std::int16_t ct_hu, std::uint8_t id) const {
    if (!follows_hu[id]) return label[id];
    const glm::vec4 curve = hu[std::size_t(std::clamp(int(ct_hu), kHuBegin, kHuEnd - 1) - kHuBegin)];
    return label[id].a < 0.0f ? curve : label[id] * curve.a;
}

}  // namespace stylet::render
