// Maps the label ids of a data set to our labels.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "patient/package/package.h"

namespace stylet::modeller {

// The labels that an import may use: the reference patient's, with their names, ids and roles, followed by
// labels that occur only in hospital segmentations ("bone" as one mask, "cyst").
const std::vector<patient::Label>& targetTable();
// Returns null if there is no such target.
const patient::Label* findTarget(const std::string& name);
// The id of a target, which must exist.
std::uint8_t targetId(const std::string& name);

// By the label's roles, so for labels of any package.
bool isLung(const patient::Label&);
bool isBone(const patient::Label&);

// Replaces the package's label table by the targets that occur in its labels. `provenance` returns the origin
// of a label.
void fillLabelTable(patient::Package&, const std::function<std::string(const patient::Label&)>& provenance);

// A CSV file: `source_id,tissue`, one line per id. `tissue` is a target's name, or "unsegmented" if CT
// thresholds should decide. Lines starting with # are comments; the values of `# source:` and `# licence:`
// are stored in the package.
struct LabelMap {
    std::map<int, std::uint8_t> target_of;  // source id -> id in targetTable(), 0 = unsegmented
    std::string source, licence;
};
LabelMap loadLabelMap(const std::filesystem::path& csv);  // throws DataError: FILE: line N: reason
// Parses the text. `csv` is only used in error messages.
LabelMap parseLabelMap(const std::filesystem::path& csv, std::string_view text);

}  // namespace stylet::modeller
