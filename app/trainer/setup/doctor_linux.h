// System queries of `stylet doctor`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace stylet::trainer {

// Real-time rights that the system refuses. The check does not change the calling thread's own priority.
struct RealTimeLimits {
    std::string priority_refused, memory_refused;  // reason; empty: granted
};
RealTimeLimits realTimeLimits();

// Free space for this user, and the reason why no file can be created (empty: files can be created).
struct FolderState {
    std::uintmax_t free_bytes = 0;
    std::string refused;
};
FolderState folderState(const std::filesystem::path&);

// First line of a file; empty if it cannot be read.
std::string firstLine(const std::filesystem::path&);

}  // namespace stylet::trainer
