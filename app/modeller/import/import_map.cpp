#include "app/modeller/import/import_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "base/line_reader.h"
#include "base/text.h"
#include "base/utf8.h"
#include "base/whole_file.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using patient::Label;
using patient::Role;
using patient::Tissue;

namespace {

constexpr std::size_t kMaxMapBytes = 1 << 20, kMaxLineBytes = 1000;
constexpr int kMaxLines = 10000;
constexpr std::string_view kHeader = "source_id,tissue";

// The value of a comment `# key: value`, or an empty text.
std::string_view parseKey(std::string_view line, const std::string& key) {
    const std::string start = "# " + key + ":";
    return line.starts_with(start) ? trimmed(line.substr(start.size())) : "";
}

void parseRow(std::string_view line, LabelMap& map, const LineReader& lines) {
    const auto comma = line.find(',');
    if (comma == std::string::npos) lines.refuse("two fields are needed, source_id,tissue");
    const std::string id_text(trimmed(line.substr(0, comma))), name(trimmed(line.substr(comma + 1)));
    const auto id = parseNumber<int>(id_text);
    if (!id || *id < 0 || *id > 32767)
        lines.refuse("source_id \"" + id_text + "\" is not a whole number from 0 to 32767");
    const Label* target = findTarget(name);
    if (*id == 0 && name != "unsegmented")
        lines.refuse("source_id 0 is the background of a segmentation; its target can only be unsegmented");
    if (!target && name != "unsegmented") {
        std::string known = "unsegmented";
        for (const Label& l : targetTable())
            known += ", " + l.name;
        lines.refuse("there is no target \"" + name + "\"; targets are " + known);
    }
    if (!map.target_of.emplace(*id, target ? target->id : std::uint8_t{0}).second)
        lines.refuse("source_id " + std::to_string(*id) + " is mapped twice");
}

}  // namespace

const Label* findTarget(const std::string& name) {
    for (const Label& l : targetTable())
        if (l.name == name) return &l;
    return nullptr;
}

std::uint8_t targetId(const std::string& name) {
    return findTarget(name)->id;
}

bool isLung(const Label& l) {
    return l.structure == patient::Structure::lung;
}

bool isBone(const Label& l) {
    return l.tissue == Tissue::bone;
}

void fillLabelTable(patient::Package& p, const std::function<std::string(const Label&)>& provenance) {
    std::array<bool, 256> used{};
    for (const std::uint8_t id : p.labels.voxels)
        used[id] = true;
    p.label_table.clear();
    for (Label l : targetTable()) {
        if (!used[l.id]) continue;
        l.provenance = provenance(l);
        p.label_table.push_back(l);
    }
}

LabelMap loadLabelMap(const fs::path& csv) {
    return parseLabelMap(csv, readWholeFile(csv, kMaxMapBytes));
}

LabelMap parseLabelMap(const fs::path& csv, std::string_view text) {
    LabelMap map;
    bool header_seen = false;
    LineReader lines(csv, text);
    for (int number = 1; !lines.done(); ++number) {
        const std::string_view line = trimmed(lines.next());
        if (!isUtf8(line)) lines.refuse("not UTF-8; save the file as UTF-8");
        if (number > kMaxLines || line.size() > kMaxLineBytes) lines.refuse("too long for a label map");
        if (line.empty()) continue;
        if (line[0] == '#') {
            if (const std::string_view v = parseKey(line, "source"); !v.empty()) map.source = v;
            if (const std::string_view v = parseKey(line, "licence"); !v.empty()) map.licence = v;
        } else if (!header_seen) {
            if (line != kHeader)
                lines.refuse(fmt::format("the header must be \"{}\", separated by a comma; it is \"{}\"",
                                         kHeader, line.substr(0, 40)));
            header_seen = true;
        } else {
            parseRow(line, map, lines);
        }
    }
    if (map.target_of.empty()) throw DataError(csv, "source_id", "the file maps nothing");
    return map;
}

const std::vector<Label>& targetTable() {
    static const std::vector<Label> table = [] {
        std::vector<Label> t = patient::synth::labelTable();
        const auto add = [&](const char* name, Tissue tissue, Role role, bool abdominal,
                             std::array<std::uint8_t, 3> colour) {
            Label label;
            label.id = std::uint8_t(t.back().id + 1), label.name = name;
            label.tissue = tissue, label.role = role, label.abdominal = abdominal;
            label.colour = colour;
            t.push_back(label);
        };
        add("bone", Tissue::bone, Role::risk, false, {241, 230, 205});
        add("cyst", Tissue::liver, Role::pass, true, {120, 150, 170});
        add("suspected vessels", Tissue::liver, Role::suspect, true, {170, 95, 80});
        return t;
    }();
    return table;
}

}  // namespace stylet::modeller
