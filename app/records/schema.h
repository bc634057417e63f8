// The schema of store.sqlite, a step a version. README.md says what the columns mean.
#pragma once

#include <span>

namespace stylet::records {

inline constexpr int kStoreId = 0x5374796c;  // PRAGMA application_id, "Styl"

// Step i brings PRAGMA user_version from i to i + 1. A step that a program was shipped with never changes.
std::span<const char* const> schemaSteps();

}  // namespace stylet::records
