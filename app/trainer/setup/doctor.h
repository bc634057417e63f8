// `stylet doctor`: checks whether this computer has everything that the trainer needs. Explains what to do
// about each problem.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "haptics/devices/devices.h"

namespace stylet::trainer {

enum class FindingState : std::uint8_t { ok, warning, problem };

// One line: what was checked, the result, and the suggested action (empty: none).
struct Finding {
    std::string what;
    FindingState state = FindingState::ok;
    std::string found, todo{};
};

// Drops `todo` if `fine` is true.
inline Finding warnUnless(bool fine, std::string what, std::string found, const std::string& todo) {
    return {std::move(what), fine ? FindingState::ok : FindingState::warning, std::move(found),
            fine ? "" : todo};
}

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

// Prints the findings. Returns exit status 0 if there is no problem, else 1.
int doctor(const DoctorOptions&) noexcept;

// Runs in a child process that examine() starts for a check that may hang or crash: "runtime" or "vulkan".
// Prints one line of JSON before each step and for each finding. The exit status has no meaning.
int probe(const std::string& what, std::chrono::milliseconds patience);

// Parses the output of that child and appends its findings. Skips all other lines. Returns the step in which
// the child ended; empty if it completed all steps.
std::string parseProbeLines(const std::vector<std::string>& lines, std::vector<Finding>&);

}  // namespace stylet::trainer
