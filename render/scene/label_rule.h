// A rule for some of a patient's labels.
#pragma once

#include <optional>

#include "base/fields.h"
#include "patient/patient.h"

namespace stylet::render {

// Applies to the labels that have all of the given roles; without any, to every label. In a list of rules the
// first matching one wins.
struct LabelRule {
    std::optional<patient::Tissue> tissue;
    std::optional<patient::BloodKind> blood;
    std::optional<patient::Structure> structure;

    bool matches(const patient::Label& label) const noexcept {
        return tissue.value_or(label.tissue) == label.tissue && blood.value_or(label.blood) == label.blood &&
               structure.value_or(label.structure) == label.structure;
    }
};

// Reads the optional keys `tissue`, `blood` and `structure`. Throws DataError for an unknown value.
inline void readLabelRule(Fields& in, LabelRule& rule) {
    if (in.has("tissue")) rule.tissue = in.choice<patient::Tissue>("tissue", patient::kTissueNames);
    if (in.has("blood")) rule.blood = in.choice<patient::BloodKind>("blood", patient::kBloodNames);
    if (in.has("structure"))
        rule.structure = in.choice<patient::Structure>("structure", patient::kStructureNames);
    if (in.has("name")) in.refuse("name", "labels are not selected by name: use tissue, blood or structure");
}

}  // namespace stylet::render
