#include "render/ultrasound/acoustics.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/fields.h"
#include "base/whole_file.h"

namespace stylet::render {
namespace {

using std::filesystem::path;

constexpr std::size_t kMaxAcousticsBytes = 1 << 20, kMaxRules = 10'000;
constexpr double kRaylPerMrayl = 1e6, kPerCm = 100.0;

Acoustic readAcoustic(Fields& t) {
    Acoustic a;
    a.name = t.nonEmptyText("name");
    a.impedance_rayl = kRaylPerMrayl * t.number("impedance_mrayl", 1e-5, 200.0);
    a.attenuation_db_per_m_mhz = kPerCm * t.number("attenuation_db_per_cm_mhz", 0.0, 1000.0);
    a.speed_m_per_s = t.number("speed_m_per_s", 100.0, 10000.0);
    a.scatter_db = t.number("scatter_db", -200.0, 0.0);
    a.hu_span = t.numberOr("hu_span", 1.0, 10000.0, 0.0);
    a.hu_centre = t.numberOr("hu", -2000.0, 10000.0, 0.0);
    a.impedance_by_hu = t.numberOr("impedance_by_hu", -0.5, 0.5, 0.0);
    a.scatter_by_hu_db = t.numberOr("scatter_by_hu_db", -40.0, 40.0, 0.0);
    if (t.has("wall_db")) {
        a.wall_db = t.number("wall_db", -200.0, 0.0);
        a.wall_m = 1e-3 * t.number("wall_mm", 0.05, 5.0);
    }
    a.solid = t.has("solid") && t.flag("solid");
    a.source = t.nonEmptyText("source");
    return a;
}

int findAcoustic(const AcousticTable& table, const std::string& name) {
    const auto found = std::find_if(table.acoustics.begin(), table.acoustics.end(),
                                    [&](const Acoustic& a) { return a.name == name; });
    return found == table.acoustics.end() ? -1 : int(found - table.acoustics.begin());
}

int readAcousticName(Fields& t, const AcousticTable& table) {
    const std::string name = t.nonEmptyText("acoustic");
    const int index = findAcoustic(table, name);
    if (index < 0) t.refuse("acoustic", "there is no tissue '" + name + "'");
    return index;
}

AcousticRule readAcousticRule(Fields& t, const AcousticTable& table) {
    AcousticRule rule;
    readLabelRule(t, rule);
    if (!rule.tissue && !rule.blood && !rule.structure)
        t.refuse("tissue", "a rule needs a tissue, a blood or a structure");
    rule.acoustic = readAcousticName(t, table);
    return rule;
}

}  // namespace

AcousticTable loadAcoustics(const path& file) {
    return parseAcoustics(file, readWholeFile(file, kMaxAcousticsBytes));
}

AcousticTable parseAcoustics(const path& file, std::string_view text) {
    Fields root = parseToml(file, text);
    AcousticTable table;
    for (Fields& t : root.childrenOrNone("tissue", kMaxAcoustics)) {
        const Acoustic a = readAcoustic(t);
        if (findAcoustic(table, a.name) >= 0) t.refuse("name", "'" + a.name + "' is there twice");
        table.acoustics.push_back(a);
    }
    const auto needed = [&](const char* name) {
        const int index = findAcoustic(table, name);
        if (index < 0) root.refuse("tissue", std::string("there is no '") + name + "', which is needed");
        return index;
    };
    table.air = needed("air");
    table.gel = needed("gel");
    table.steel = needed("steel");
    table.roughness = root.number("roughness", 0.0, 1.0);
    for (Fields& t : root.childrenOrNone("label", kMaxRules))
        table.rules.push_back(readAcousticRule(t, table));
    for (Fields& t : root.childrenOrNone("hu", kMaxRules)) {
        const HuClass c{t.number("from_hu", -2000.0, 10000.0), readAcousticName(t, table)};
        if (!table.hu.empty() && c.from_hu <= table.hu.back().from_hu) t.refuse("from_hu", "not ascending");
        table.hu.push_back(c);
    }
    if (table.hu.empty()) root.refuse("hu", "at least one [[hu]] class is needed");
    return table;
}

int AcousticTable::acousticForHu(double hu_value) const {
    int found = hu.front().acoustic;
    for (const HuClass& c : hu)
        if (c.from_hu <= hu_value) found = c.acoustic;
    return found;
}

std::array<int, 256> acousticsByLabel(const AcousticTable& table, const patient::Patient& patient) {
    std::array<int, 256> rows;
    rows.fill(-1);
    for (int id = 1; id < 256; ++id) {
        const patient::Label* label = patient.label(std::uint8_t(id));
        if (!label) continue;
        const auto rule = std::find_if(table.rules.begin(), table.rules.end(),
                                       [&](const AcousticRule& r) { return r.matches(*label); });
        if (rule != table.rules.end()) rows[std::size_t(id)] = rule->acoustic;
    }
    return rows;
}

double reflectivity(const Acoustic& from, const Acoustic& to) {
    return (to.impedance_rayl - from.impedance_rayl) / (to.impedance_rayl + from.impedance_rayl);
}

}  // namespace stylet::render
