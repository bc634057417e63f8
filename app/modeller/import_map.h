// Which of a data set's label ids becomes which label of ours.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "patient/tissue.h"

namespace stylet::modeller {

// The labels an import may give: those of the reference patient under their own names and ids, then what only
// hospital segmentations have ("bone" as one mask, "cyst").
const std::vector<patient::Label>& targetTable();
// Null where there is no such target.
const patient::Label* findTarget(const std::string& name);

// A CSV file: `source_id,tissue`, one line per id. `tissue` is a target's name, or "unsegmented" where
// thresholds over the CT are to decide. Lines that begin with # are comments; `# source:` and `# licence:`
// among them go into the package.
struct LabelMap {
    std::map<int, std::uint8_t> target_of;  // source id -> id in targetTable(), 0 = unsegmented
    std::string source, licence;
};
LabelMap loadLabelMap(const std::filesystem::path& csv);  // throws ImportError: FILE: line N: reason
// The same from memory; `csv` is only named in refusals.
LabelMap parseLabelMap(const std::filesystem::path& csv, std::string_view text);

}  // namespace stylet::modeller
