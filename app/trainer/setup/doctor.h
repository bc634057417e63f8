// `stylet doctor`: checks this computer for everything the trainer needs, and says what to do about
// problems.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptics/devices/devices.h"

namespace stylet::trainer {

enum class FindingState : std::uint8_t { ok, warning, problem };

// One line: what was checked, the result, and what to do (empty: nothing).
struct Finding {
    std::string what;
    FindingState state = FindingState::ok;
    std::string found, todo{};
};

struct DoctorOptions {
    haptics::DeviceOptions devices{};
    std::filesystem::path records{};  // folder whose records are all checked; empty: none
    bool json = false;
    // Timeout for each check of a runtime or graphics driver. Each runs in a child process.
    std::chrono::milliseconds patience{5000};
};

// Always returns. A check that hangs or crashes is abandoned and reported as a problem.
std::vector<Finding> examine(const DoctorOptions&) noexcept;

std::string describeFindings(const std::vector<Finding>&, bool as_json);

// Prints the findings. Returns exit status 0 without problems, 1 with problems.
int doctor(const DoctorOptions&) noexcept;

// Child process that examine() starts for a check that may hang or crash: "runtime" or "vulkan". Prints one
// line of JSON before each step and for each finding. The exit status has no meaning.
int probe(const std::string& what, std::chrono::milliseconds patience);

// Parses the output of that child and skips all other lines. Appends its findings. Returns the step in
// which the child ended; empty if it completed.
std::string takeProbeLines(const std::vector<std::string>& lines, std::vector<Finding>&);

}  // namespace stylet::trainer
