#include "patient/package/package_toml.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>

#include "base/fields.h"
#include "base/text.h"

namespace stylet::patient {
namespace {

constexpr double kMinYoung_pa = 10.0;  // softer than any tissue; a smaller value has the wrong unit
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct ThresholdKey {
    const char* name;
    double Thresholds::* value;
};
constexpr std::array kThresholdKeys{ThresholdKey{"t0_hu", &Thresholds::t0_hu},
                                    ThresholdKey{"t1_hu", &Thresholds::t1_hu},
                                    ThresholdKey{"t2_sensitive_hu", &Thresholds::t2_sensitive_hu},
                                    ThresholdKey{"t2_specific_hu", &Thresholds::t2_specific_hu}};

Thresholds readThresholds(Fields in) {
    Thresholds t;
    const ThresholdKey* below = nullptr;
    for (const ThresholdKey& key : kThresholdKeys) {
        t.*key.value = in.number(key.name, -1024, 3071);
        if (below && t.*key.value < t.*below->value)
            in.refuse(key.name, fmt::format("below {}", below->name));
        below = &key;
    }
    in.finish();
    return t;
}

TissueRow readRow(Fields& in) {
    TissueRow row;
    row.role = in.choice<Role>("role", kRoleNames);
    row.cut_force_n = in.number("cut_force_n", 0.0, kInfinity);
    row.friction_n = in.number("friction_n", 0.0, 1000.0);
    row.stiffness_n_per_m = in.number("stiffness_n_per_m", 0.0, 1e6);
    row.membrane = in.flag("membrane");
    if (row.stiffness_n_per_m == 0.0 && (row.cut_force_n > 0.0 || row.friction_n > 0.0))
        in.refuse("stiffness_n_per_m", "zero, but the tissue has a force");
    return row;
}

Elasticity readElasticity(Fields& in) {
    return {in.number("young_pa", kMinYoung_pa, kInfinity), in.text("young_source", 1000)};
}

void readTissues(Fields& root, TissueTable& table, ElasticityTable& elasticity) {
    std::array<bool, kTissueCount> seen{};
    for (Fields& in : root.childrenOrNone("tissue", kTissueCount)) {
        const auto index = std::size_t(in.choice<Tissue>("name", kTissueNames));
        if (seen[index]) in.refuse("name", "given twice");
        seen[index] = true;
        table[index] = readRow(in);
        elasticity[index] = readElasticity(in);
        in.finish();
    }
    for (std::size_t t = 0; t < seen.size(); ++t)
        if (!seen[t]) root.refuse("tissue", fmt::format("no row named \"{}\"", kTissueNames[t]));
}

constexpr double kPackageReach_m = 10.0;
constexpr double kMaxUncertainty_m = 0.02, kMaxSlice_m = 0.1;
constexpr const char* kPackageFormat = "stylet patient 5";
constexpr const char* kEllipticalFormat = "stylet patient 1";
constexpr const char* kFormatWithoutElasticity = "stylet patient 2";
constexpr const char* kFormatWithoutRoles = "stylet patient 3";
constexpr const char* kFormatWithoutCartilage = "stylet patient 4";
constexpr std::size_t kMaxAtlases = 1000, kMaxAtlasNameBytes = 200;

Label readLabel(Fields& in) {
    Label label;
    label.id = std::uint8_t(in.integer("id", 1, 255));
    label.name = in.text("name", 200);
    label.tissue = in.choice<Tissue>("tissue", kTissueNames);
    label.role = in.choice<Role>("role", kRoleNames);
    label.abdominal = in.flag("abdominal");
    label.blood = in.choice<BloodKind>("blood", kBloodNames);
    label.structure = in.choice<Structure>("structure", kStructureNames);
    label.blocks_contrast = in.flag("blocks_contrast");
    label.drains_ducts = in.flag("drains_ducts");
    if (const auto conflict = findRoleConflict(label))
        in.refuse(conflict->field, std::string(conflict->reason));
    label.provenance = in.text("provenance", 1000);
    label.border_uncertainty_m = in.numberOr("border_uncertainty_m", 0.0, kMaxUncertainty_m, 0.0);
    const std::vector<std::int64_t> colour = in.integers("colour", 0, 255, 3);
    if (colour.size() != 3) in.refuse("colour", "not 3 integers");
    std::copy(colour.begin(), colour.end(), label.colour.begin());
    in.finish();
    return label;
}

std::vector<Label> readLabels(Fields& root) {
    std::vector<Label> labels;
    std::array<bool, 256> seen{};
    for (Fields& in : root.childrenOrNone("label", 255)) {
        labels.push_back(readLabel(in));
        if (seen[labels.back().id]) in.refuse("id", fmt::format("{} is given twice", labels.back().id));
        seen[labels.back().id] = true;
    }
    return labels;
}

Grid readGrid(Fields in) {
    Grid grid;
    grid.spacing_m = in.vector("spacing_m", -kPackageReach_m, kPackageReach_m);
    grid.origin_m = in.vector("origin_m", -kPackageReach_m, kPackageReach_m);
    for (int axis = 0; axis < 3; ++axis)
        if (!(grid.spacing_m[axis] > 0.0)) in.refuse("spacing_m", "not above 0");
    in.finish();
    return grid;
}

SurrogateRange readRange(Fields& in, std::string_view low_key, std::string_view high_key, double limit) {
    const SurrogateRange range{in.number(low_key, -limit, limit), in.number(high_key, -limit, limit)};
    if (!(range.low < range.high)) in.refuse(high_key, fmt::format("not above {}", low_key));
    return range;
}

void readBreathing(Fields in, Package& p) {
    p.signal.period_s = in.number("period_s", 0.5, 60.0);
    p.signal.amplitude = in.number("amplitude", 0.0, 2.0);
    p.motion.v = readRange(in, "v_low", "v_high", 3.0);
    p.motion.rate_per_s = readRange(in, "rate_low_per_s", "rate_high_per_s", 20.0);
    p.motion.dome_travel_m = in.number("dome_travel_m", 0.0, 0.1);
    in.finish();
}

ScanProperties readScan(Fields in) {
    ScanProperties scan;
    scan.slice_m = in.numberOr("slice_m", 0.0, kMaxSlice_m, 0.0);
    scan.blur_within_m = in.numberOr("blur_within_m", 0.0, kMaxSlice_m, 0.0);
    in.finish();
    return scan;
}

// "exhale", "inhale" or "v=0.35".
Surrogate readReference(const Fields& root, const std::string& phase) {
    if (phase == "exhale") return {0.0, 0.0};
    if (phase == "inhale") return {1.0, 0.0};
    if (phase.starts_with("v=")) {
        const auto v = parseNumber<double>(std::string_view(phase).substr(2));
        if (v && *v >= 0.0 && *v <= 2.0) return {*v, 0.0};
    }
    root.refuse("reference_phase", "not \"exhale\", \"inhale\" or \"v=...\" in [0, 2]");
}

// Shortest text that reads back bit-equal.
std::string numberText(double value) {
    const std::string text = shortestText(value);
    return text.find_first_of(".enN") == std::string::npos ? text + ".0" : text;
}

std::string tomlText(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') {
            out += '\\', out += c;
        } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
            out += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
        } else {
            out += c;
        }
    }
    return out + "\"";
}

class TomlWriter {
  public:
    void line(std::string_view text = "") { text_.append(text).append("\n"); }
    void put(std::string_view key, double value) { entry(key, numberText(value)); }
    void put(std::string_view key, bool value) { entry(key, value ? "true" : "false"); }
    void put(std::string_view key, int value) { entry(key, std::to_string(value)); }
    void put(std::string_view key, std::string_view value) { entry(key, tomlText(value)); }
    void put(std::string_view key, const char* value) { put(key, std::string_view(value)); }
    void put(std::string_view key, const Vec3& v) {
        entry(key, fmt::format("[{}, {}, {}]", numberText(v.x), numberText(v.y), numberText(v.z)));
    }
    void put(std::string_view key, const std::vector<std::string>& values) {
        std::string list;
        for (const std::string& value : values)
            list += (list.empty() ? "" : ", ") + tomlText(value);
        entry(key, "[" + list + "]");
    }
    void entry(std::string_view key, std::string_view value) {
        text_.append(key).append(" = ").append(value).append("\n");
    }
    std::string release() { return std::move(text_); }

  private:
    std::string text_;
};

void writeTissues(TomlWriter& out, const Package& p) {
    out.line("\n[thresholds]");
    for (const ThresholdKey& key : kThresholdKeys)
        out.put(key.name, p.thresholds.*key.value);
    for (int t = 0; t < kTissueCount; ++t) {
        const TissueRow& row = p.tissues[std::size_t(t)];
        out.line("\n[[tissue]]");
        out.put("name", tissueName(Tissue(t)));
        out.put("role", roleName(row.role));
        out.put("cut_force_n", row.cut_force_n);
        out.put("friction_n", row.friction_n);
        out.put("stiffness_n_per_m", row.stiffness_n_per_m);
        out.put("membrane", row.membrane);
        out.put("young_pa", p.elasticity[std::size_t(t)].young_pa);
        out.put("young_source", p.elasticity[std::size_t(t)].source);
    }
}

void writeLabels(TomlWriter& out, const Package& p) {
    for (const Label& label : p.label_table) {
        out.line("\n[[label]]");
        out.put("id", int(label.id));
        out.put("name", label.name);
        out.put("tissue", tissueName(label.tissue));
        out.put("role", roleName(label.role));
        out.put("abdominal", label.abdominal);
        out.put("blood", bloodName(label.blood));
        out.put("structure", structureName(label.structure));
        out.put("blocks_contrast", label.blocks_contrast);
        out.put("drains_ducts", label.drains_ducts);
        out.entry("colour", fmt::format("[{}, {}, {}]", label.colour[0], label.colour[1], label.colour[2]));
        out.put("provenance", label.provenance);
        if (label.border_uncertainty_m > 0.0) out.put("border_uncertainty_m", label.border_uncertainty_m);
    }
}

void writeBreathing(TomlWriter& out, const Package& p) {
    out.line("\n[breathing]");
    out.put("period_s", p.signal.period_s);
    out.put("amplitude", p.signal.amplitude);
    out.put("v_low", p.motion.v.low);
    out.put("v_high", p.motion.v.high);
    out.put("rate_low_per_s", p.motion.rate_per_s.low);
    out.put("rate_high_per_s", p.motion.rate_per_s.high);
    out.put("dome_travel_m", p.motion.dome_travel_m);
}

}  // namespace

TissueDefaults parseTissueDefaults(const std::filesystem::path& file, std::string_view text) {
    Fields root = parseToml(file, text);
    TissueDefaults defaults;
    defaults.thresholds = readThresholds(root.child("thresholds"));
    readTissues(root, defaults.tissues, defaults.elasticity);
    root.finish();
    return defaults;
}

Package parsePackageToml(const std::filesystem::path& file, std::string_view text) {
    Fields root = parseToml(file, text);
    const std::string format = root.text("format", 100);
    if (format == kEllipticalFormat)
        root.refuse("format", "an older format with elliptical breathing: make or import the patient again");
    if (format == kFormatWithoutElasticity)
        root.refuse("format", "an older patient, whose tissues have no elasticity: make or import it again");
    if (format == kFormatWithoutRoles)
        root.refuse("format",
                    "an older patient, whose labels have no roles (blood, structure, ...): make, import or "
                    "build it again");
    if (format == kFormatWithoutCartilage)
        root.refuse("format", "an older patient, in which cartilage is bone: make, import or build it again");
    if (format != kPackageFormat) root.refuse("format", fmt::format("not \"{}\"", kPackageFormat));
    Package p;
    p.name = root.text("name", 200);
    p.licence = root.text("licence", 2000);
    p.provenance = root.text("provenance", 2000);
    p.atlases = root.texts("atlases", kMaxAtlases, kMaxAtlasNameBytes);
    p.reference_phase = root.text("reference_phase", 40);
    p.ct.grid = p.labels.grid = readGrid(root.child("grid"));
    p.thresholds = readThresholds(root.child("thresholds"));
    readTissues(root, p.tissues, p.elasticity);
    p.label_table = readLabels(root);
    p.motion.reference = readReference(root, p.reference_phase);
    readBreathing(root.child("breathing"), p);
    if (root.has("scan")) p.scan = readScan(root.child("scan"));
    if (root.has("motion_grid")) {
        p.motion.grid = readGrid(root.child("motion_grid"));
        p.motion.grid.dims = Index3(1);  // placeholder; motion.nii.gz contains the real size
    }
    root.finish();
    return p;
}

std::string packageToml(const Package& p) {
    TomlWriter out;
    out.put("format", kPackageFormat);
    out.put("name", p.name);
    out.put("licence", p.licence);
    out.put("provenance", p.provenance);
    out.put("atlases", p.atlases);
    out.put("reference_phase", p.reference_phase);
    out.line("\n# Exact; the volumes' own headers hold single precision.\n[grid]");
    out.put("spacing_m", p.ct.grid.spacing_m);
    out.put("origin_m", p.ct.grid.origin_m);
    if (p.motion.grid.dims.x > 0) {
        out.line("\n# Of motion.nii.gz.\n[motion_grid]");
        out.put("spacing_m", p.motion.grid.spacing_m);
        out.put("origin_m", p.motion.grid.origin_m);
    }
    if (p.scan.slice_m > 0.0 || p.scan.blur_within_m > 0.0) {
        out.line("\n# Of the scan from which the CT was made.\n[scan]");
        if (p.scan.slice_m > 0.0) out.put("slice_m", p.scan.slice_m);
        if (p.scan.blur_within_m > 0.0) out.put("blur_within_m", p.scan.blur_within_m);
    }
    writeTissues(out, p);
    writeLabels(out, p);
    writeBreathing(out, p);
    return out.release();
}

}  // namespace stylet::patient
