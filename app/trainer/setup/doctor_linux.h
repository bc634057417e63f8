// System queries of `stylet doctor`.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stylet::trainer {

// Result of a program that ran in its own process group: its stdout, line by line. Its stderr is discarded.
struct ChildOutcome {
    std::vector<std::string> lines;
    bool started = false;
    bool in_time = false;       // false: its process group was killed, or left behind if that failed
    std::optional<int> status;  // exit status, if it exited
    std::optional<int> signal;  // signal that ended it
};
ChildOutcome runChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                      std::chrono::milliseconds patience);

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
