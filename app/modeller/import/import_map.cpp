#include "app/modeller/import/import_map.h"

#include <algorithm>
#include <charconv>

#include "app/modeller/image/import_image.h"
#include "base/whole_file.h"
#include "patient/synth/synth.h"

namespace stylet::modeller {

namespace fs = std::filesystem;
using patient::Label;
using patient::Role;
using patient::Tissue;

namespace {

constexpr std::size_t kMaxMapBytes = 1 << 20;

std::string trimmed(const std::string& s) {
    const auto from = s.find_first_not_of(" \t\r");
    return from == std::string::npos ? "" : s.substr(from, s.find_last_not_of(" \t\r") - from + 1);
}

// The value of a comment `# key: value`, or an empty text.
std::string keyed(const std::string& line, const std::string& key) {
    const std::string start = "# " + key + ":";
    return line.rfind(start, 0) == 0 ? trimmed(line.substr(start.size())) : "";
}

void takeLine(const std::string& line, LabelMap& map, const auto& refuse) {
    const auto comma = line.find(',');
    if (comma == std::string::npos) refuse("two fields are needed, source_id,tissue");
    const std::string id_text = trimmed(line.substr(0, comma)), name = trimmed(line.substr(comma + 1));
    int id = -1;
    const auto [end, error] = std::from_chars(id_text.data(), id_text.data() + id_text.size(), id);
    if (error != std::errc() || end != id_text.data() + id_text.size() || id < 0 || id > 32767)
        refuse("source_id \"" + id_text + "\" is not a whole number from 0 to 32767");
    const Label* target = findTarget(name);
    if (!target && name != "unsegmented") {
        std::string known = "unsegmented";
        for (const Label& l : targetTable())
            known += ", " + l.name;
        refuse("there is no target \"" + name + "\"; targets are " + known);
    }
    if (!map.target_of.emplace(id, target ? target->id : std::uint8_t{0}).second)
        refuse("source_id " + std::to_string(id) + " is mapped twice");
}

}  // namespace

const Label* findTarget(const std::string& name) {
    for (const Label& l : targetTable())
        if (l.name == name) return &l;
    return nullptr;
}

LabelMap loadLabelMap(const fs::path& csv) {
    return parseLabelMap(csv, readWholeFile(csv, kMaxMapBytes));
}

LabelMap parseLabelMap(const fs::path& csv, std::string_view text) {
    LabelMap map;
    bool header_seen = false;
    for (int number = 1; !text.empty(); ++number) {
        const std::string_view raw = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(raw.size() + 1, text.size()));
        const auto refuse = [&](const std::string& why) {
            throw ImportError(csv.string() + ": line " + std::to_string(number) + ": " + why);
        };
        if (number > 10000 || raw.size() > 1000) refuse("too long for a label map");
        const std::string line = trimmed(std::string(raw));
        if (line.empty()) continue;
        if (line[0] == '#') {
            if (const std::string v = keyed(line, "source"); !v.empty()) map.source = v;
            if (const std::string v = keyed(line, "licence"); !v.empty()) map.licence = v;
        } else if (!header_seen) {
            if (line != "source_id,tissue") refuse("the first line must be source_id,tissue");
            header_seen = true;
        } else {
            takeLine(line, map, refuse);
        }
    }
    if (map.target_of.empty()) throw ImportError(csv.string() + ": maps nothing");
    return map;
}

const std::vector<Label>& targetTable() {
    static const std::vector<Label> table = [] {
        std::vector<Label> t = patient::synth::labelTable();
        const auto add = [&](const char* name, Tissue tissue, Role role, bool abdominal,
                             std::array<std::uint8_t, 3> colour) {
            t.push_back({std::uint8_t(t.back().id + 1), name, tissue, role, abdominal, colour, ""});
        };
        add("bone", Tissue::bone, Role::risk, false, {241, 230, 205});
        add("cyst", Tissue::liver, Role::pass, true, {120, 150, 170});
        return t;
    }();
    return table;
}

}  // namespace stylet::modeller
