// What `stylet doctor` asks of the operating system.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stylet::trainer {

// A program run in a process group of its own; what it writes to stdout, line by line. Its stderr goes
// nowhere.
struct ChildOutcome {
    std::vector<std::string> lines;
    bool started = false;
    bool in_time = false;       // false: killed with all it had started, or left where that is impossible
    std::optional<int> status;  // of an exit
    std::optional<int> signal;  // of an end by one
};
ChildOutcome runChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                      std::chrono::milliseconds patience);

std::filesystem::path thisProgram();

// Of the thread that asks, which is left as it was.
struct RealTimeLimits {
    std::string priority_refused, memory_refused;  // the reason; empty: granted
};
RealTimeLimits realTimeLimits();

// Free for this user, bytes; and whether a file can be made there, the reason why not.
struct FolderState {
    std::uintmax_t free_bytes = 0;
    std::string refused;
};
FolderState folderState(const std::filesystem::path&);

// The first line of a file, empty where there is none.
std::string firstLine(const std::filesystem::path&);

}  // namespace stylet::trainer
