// System queries of `stylet doctor`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace stylet::trainer {

std::filesystem::path thisProgram();

// Real-time rights that the system refuses. The calling thread's own priority is unchanged.
struct RealTimeLimits {
    std::string priority_refused, memory_refused;  // reason; empty: granted
};
RealTimeLimits realTimeLimits();

// Free space for this user, and why no file can be created there (empty: it can).
struct FolderState {
    std::uintmax_t free_bytes = 0;
    std::string refused;
};
FolderState folderState(const std::filesystem::path&);

// First line of a file; empty if it cannot be read.
std::string firstLine(const std::filesystem::path&);

}  // namespace stylet::trainer
