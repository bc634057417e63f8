// Runs a program in a process of its own, with a deadline and optional resource limits.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace stylet {

struct ResourceLimits {
    int cpu_s = 0;
    std::size_t memory_bytes = 0;
    std::size_t file_bytes = 0;  // size limit of each file that the child writes
};

struct ChildSettings {
    std::chrono::milliseconds timeout{0};         // time from the start of the child to the deadline
    std::chrono::milliseconds kill_timeout{500};  // time for a killed child to end
    std::size_t max_text_bytes = 1 << 20;         // of its standard output; further output is dropped
    // With limits, the child also cannot gain privileges, leaves no core dump and dies with the calling
    // thread.
    std::optional<ResourceLimits> limits = std::nullopt;
};

struct ChildOutcome {
    std::string text;           // standard output; standard error is discarded
    bool started = false;       // false: no process could be created, or the program cannot be executed
    bool in_time = false;       // false: its process group was killed, or left behind if that failed
    std::optional<int> status;  // exit status, if it exited
    std::optional<int> signal;  // signal that ended it
};

// Runs the program in its own process group and waits for its end. So Ctrl-C reaches only the caller. The
// program's standard input is empty.
ChildOutcome runProgram(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                        const ChildSettings&);

}  // namespace stylet
