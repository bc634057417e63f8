// The schema of store.sqlite as migration steps, one per version. packaging/guide/records.md documents the
// columns.
#pragma once

#include <span>

namespace stylet::records {

inline constexpr int kStoreId = 0x5374796c;  // PRAGMA application_id, "Styl"

// Step i migrates PRAGMA user_version from i to i + 1. Never change a step that has been released.
std::span<const char* const> schemaSteps();

}  // namespace stylet::records
