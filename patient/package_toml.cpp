#include "patient/package_toml.h"

#include <array>
#include <cmath>
#include <limits>

#include "patient/toml_reader.h"

namespace stylet::patient {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Tissue readTissueName(TomlReader& in, std::string_view key) {
    const std::string name = in.text(key, 32);
    for (int t = 0; t < kTissueCount; ++t)
        if (name == tissueName(Tissue(t))) return Tissue(t);
    in.refuse(key, "\"" + name + "\" is not a tissue of the force table");
}

Role readRole(TomlReader& in, std::string_view key) {
    const std::string name = in.text(key, 32);
    for (const Role role : {Role::pass, Role::risk, Role::target})
        if (name == roleName(role)) return role;
    in.refuse(key, "\"" + name + "\" is not pass, risk or target");
}

Thresholds readThresholds(TomlReader in) {
    Thresholds t;
    t.t0_hu = in.number("t0_hu", -1024, 3071);
    t.t1_hu = in.number("t1_hu", -1024, 3071);
    t.t2_sensitive_hu = in.number("t2_sensitive_hu", -1024, 3071);
    t.t2_specific_hu = in.number("t2_specific_hu", -1024, 3071);
    if (t.t1_hu < t.t0_hu) in.refuse("t1_hu", "below t0_hu");
    if (t.t2_sensitive_hu < t.t1_hu) in.refuse("t2_sensitive_hu", "below t1_hu");
    if (t.t2_specific_hu < t.t2_sensitive_hu) in.refuse("t2_specific_hu", "below t2_sensitive_hu");
    in.finish();
    return t;
}

TissueRow readRow(TomlReader& in) {
    TissueRow row;
    row.role = readRole(in, "role");
    row.cut_force_n = in.number("cut_force_n", 0.0, kInfinity);
    row.friction_n = in.number("friction_n", 0.0, 1000.0);
    row.stiffness_n_per_m = in.number("stiffness_n_per_m", 0.0, 1e6);
    row.membrane = in.flag("membrane");
    if (row.stiffness_n_per_m == 0.0 && (row.cut_force_n > 0.0 || row.friction_n > 0.0))
        in.refuse("stiffness_n_per_m", "zero, but the tissue has a force");
    in.finish();
    return row;
}

TissueTable readTissues(TomlReader& root) {
    TissueTable table{};
    std::array<bool, kTissueCount> seen{};
    for (TomlReader& in : root.children("tissue", kTissueCount)) {
        const auto index = std::size_t(readTissueName(in, "name"));
        if (seen[index]) in.refuse("name", "given twice");
        seen[index] = true;
        table[index] = readRow(in);
    }
    for (std::size_t t = 0; t < seen.size(); ++t)
        if (!seen[t]) root.refuse("tissue", "no row named \"" + std::string(tissueName(Tissue(t))) + "\"");
    return table;
}

}  // namespace

TissueDefaults parseTissueDefaults(const std::filesystem::path& file, std::string_view text) {
    const toml::table parsed = parseToml(file, text);
    TomlReader root(file, "", parsed);
    TissueDefaults defaults;
    defaults.thresholds = readThresholds(root.child("thresholds"));
    defaults.tissues = readTissues(root);
    root.finish();
    return defaults;
}

}  // namespace stylet::patient
