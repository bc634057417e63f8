#include "render/volume/look.h"

#include <toml++/toml.h>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/whole_file.h"

namespace stylet::render {
namespace {

using std::filesystem::path;

constexpr std::size_t kMaxLookBytes = 1 << 20;
constexpr double kPerMm = 1000.0;

float linearFromSrgb(int byte) {
    const double c = byte / 255.0;
    return float(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
}

glm::vec3 linearFromSrgb(const std::array<std::uint8_t, 3>& c) {
    return {linearFromSrgb(c[0]), linearFromSrgb(c[1]), linearFromSrgb(c[2])};
}

glm::vec3 readColour(const path& file, const std::string& field, const std::string& text) {
    const bool hex =
        text.size() == 7 && text[0] == '#' &&
        std::all_of(text.begin() + 1, text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
    if (!hex) throw DataError(file, field, "'" + text + "' is not an sRGB colour like \"#e0c0a0\"");
    const auto byte = [&](std::size_t at) {
        return std::uint8_t(std::stoi(text.substr(at, 2), nullptr, 16));
    };
    return linearFromSrgb(std::array{byte(1), byte(3), byte(5)});
}

double readNumber(const path& file, const std::string& field, const toml::node_view<const toml::node>& node,
                  double low, double high) {
    const auto value = node.value<double>();
    if (!value) throw DataError(file, field, "missing, or not a number");
    if (!(*value >= low && *value <= high))
        throw DataError(
            file, field,
            std::to_string(*value) + " is not within " + std::to_string(low) + " to " + std::to_string(high));
    return *value;
}

std::vector<HuPoint> readCurve(const path& file, const toml::table& root) {
    std::vector<HuPoint> points;
    const toml::array* list = root["hu"].as_array();
    if (!list || list->empty()) throw DataError(file, "hu", "at least one [[hu]] point is needed");
    for (const toml::node& node : *list) {
        const std::string field = "hu[" + std::to_string(points.size()) + "]";
        const toml::table* table = node.as_table();
        if (!table) throw DataError(file, field, "not a table");
        const toml::table& t = *table;
        HuPoint point;
        point.hu = readNumber(file, field + ".hu", t["hu"], -2000.0, 10000.0);
        point.extinction_per_m =
            kPerMm * readNumber(file, field + ".extinction_per_mm", t["extinction_per_mm"], 0.0, 1000.0);
        point.colour_linear = readColour(file, field + ".colour", t["colour"].value_or(std::string()));
        if (!points.empty() && point.hu <= points.back().hu)
            throw DataError(file, field + ".hu", "not ascending");
        points.push_back(point);
    }
    return points;
}

patient::Tissue readTissue(const path& file, const std::string& field, const std::string& name) {
    for (int i = 0; i < patient::kTissueCount; ++i)
        if (patient::tissueName(patient::Tissue(i)) == name) return patient::Tissue(i);
    throw DataError(file, field, "'" + name + "' is not a tissue");
}

LookRule readLookRule(const path& file, const std::string& field, const toml::table& t) {
    LookRule rule;
    if (const auto tissue = t["tissue"].value<std::string>())
        rule.tissue = readTissue(file, field + ".tissue", *tissue);
    rule.name = t["name"].value_or(std::string());
    if (t.contains("extinction_per_mm"))
        rule.extinction_per_m =
            kPerMm * readNumber(file, field + ".extinction_per_mm", t["extinction_per_mm"], 0.0, 1000.0);
    if (t.contains("shell_per_mm"))
        rule.shell_per_m = kPerMm * readNumber(file, field + ".shell_per_mm", t["shell_per_mm"], 0.0, 1000.0);
    if (const auto colour = t["colour"].value<std::string>())
        rule.colour_linear = readColour(file, field + ".colour", *colour);
    return rule;
}

void readSurface(const path& file, const toml::table& root, LookStyle& look) {
    const auto number = [&](const char* key, double high) {
        return float(readNumber(file, std::string("surface.") + key, root["surface"][key], 0.0, high));
    };
    look.wrap = number("wrap", 1.0);
    look.specular = number("specular", 4.0);
    look.specular_power = number("specular_power", 1000.0);
    look.rim = number("rim", 4.0);
    look.gradient_voxels = number("gradient_voxels", 4.0);
    look.smoothing_voxels = int(number("smoothing_voxels", 6.0));
    look.edge_low = number("edge_low", 0.9);
    look.edge_high = number("edge_high", 1.0);
    if (look.edge_low >= look.edge_high) throw DataError(file, "surface.edge_high", "not above edge_low");
    const auto ifGiven = [&](const char* key) { return root["surface"][key] ? number(key, 1.0) : 0.0f; };
    look.mottle = ifGiven("mottle");
    look.pores = ifGiven("pores");
    look.grazing_tint =
        readColour(file, "surface.grazing_tint", root["surface"]["grazing_tint"].value_or(std::string()));
}

bool lookRuleFits(const LookRule& rule, const patient::Label& label) {
    if (rule.tissue && *rule.tissue != label.tissue) return false;
    std::string name = label.name;
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    return rule.name.empty() || name.find(rule.name) != std::string::npos;
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
    toml::table root;
    try {
        root = toml::parse(text);
    } catch (const toml::parse_error& e) {
        throw DataError(file, "line " + std::to_string(e.source().begin.line), std::string(e.description()));
    }
    look.name = root["name"].value_or(file.stem().string());
    look.hu = readCurve(file, root);
    if (const toml::array* list = root["rule"].as_array()) {
        for (const toml::node& node : *list) {
            const std::string field = "rule[" + std::to_string(look.rules.size()) + "]";
            if (!node.is_table()) throw DataError(file, field, "not a table");
            look.rules.push_back(readLookRule(file, field, *node.as_table()));
        }
    }
    readSurface(file, root, look);
    double full = 0.0;
    for (const HuPoint& p : look.hu)
        full = std::max(full, p.extinction_per_m);
    for (const LookRule& r : look.rules)
        full = std::max(full, r.extinction_per_m.value_or(0.0));
    if (full <= 0.0) throw DataError(file, "extinction_per_mm", "nothing would be visible");
    look.full_extinction_per_m = full;
    return look;
}

Palette resolve(const LookStyle& look, const patient::Patient& patient) {
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
                                       [&](const LookRule& r) { return lookRuleFits(r, *label); });
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
