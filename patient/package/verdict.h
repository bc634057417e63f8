// The verdict of `stylet-model check` on a package, stored beside it in verdict.json. The file names the
// package by its digest and carries a checksum, so that an edit of the verdict or of the package is noticed.
// The checksum protects against mistakes, not against a person who forges it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "patient/package/package.h"

namespace stylet::patient {

struct CheckVerdict {
    std::uint64_t patient_digest = 0;   // digest(Package)
    bool refused = false;               // the package cannot be simulated
    std::vector<std::string> findings;  // one line each, worst first
    friend bool operator==(const CheckVerdict&, const CheckVerdict&) = default;
};

// Writes verdict.json into the package's folder, over an older one. Throws DataError.
void saveVerdict(const CheckVerdict&, const std::filesystem::path& folder);
// Returns nothing if there is no verdict. Throws DataError if it was edited or is damaged.
std::optional<CheckVerdict> loadVerdict(const std::filesystem::path& folder);
// Parses the contents of verdict.json. `file` is used in error messages.
CheckVerdict parseVerdict(const std::filesystem::path& file, std::string_view text);

inline constexpr std::string_view kNotChecked = "not checked";

// Whether the verdict in `folder` allows the package to be used. Throws DataError if the package was refused,
// if it was changed after its check, or if the verdict was edited; the message says what to do. With
// `accept_implausible`, none of this throws.
// Returns what an attempt has to record: nothing for an accepted package, otherwise one line: kNotChecked, or
// why the package would have been refused.
std::string requirePlausible(const Package&, const std::filesystem::path& folder, bool accept_implausible);

}  // namespace stylet::patient
