// A rule for some of a patient's labels.
#pragma once

#include <algorithm>
#include <cctype>
#include <optional>
#include <string>

#include "patient/patient.h"

namespace stylet::render {

// Applies to the labels whose tissue and name match. In a list of rules the first matching one wins.
struct LabelRule {
    std::optional<patient::Tissue> tissue;
    std::string name;  // part of the label's name, lower case; empty = any

    bool matches(const patient::Label& label) const {
        if (tissue && *tissue != label.tissue) return false;
        std::string lower = label.name;
        std::transform(lower.begin(), lower.end(), lower.begin(),
                       [](unsigned char c) { return char(std::tolower(c)); });
        return lower.find(name) != std::string::npos;
    }
};

}  // namespace stylet::render
