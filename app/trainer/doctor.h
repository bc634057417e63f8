// `stylet doctor`: what this machine has for the trainer, what stands in the way, and what to do about it.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptics/devices/devices.h"

namespace stylet::trainer {

enum class FindingState : std::uint8_t { ok, warning, problem };

// A line: what was looked at, what was found there, and what to do (empty: nothing).
struct Finding {
    std::string what;
    FindingState state = FindingState::ok;
    std::string found, todo{};
};

struct DoctorOptions {
    haptics::DeviceOptions devices{};
    std::filesystem::path records{};  // a folder in which all records are read; empty: none
    bool json = false;
    // For all that a runtime or a graphics driver is asked, each in a process of its own.
    std::chrono::milliseconds patience{5000};
};

// Never throws, and always returns: what hangs or dies is left behind and is a problem with a name.
std::vector<Finding> examine(const DoctorOptions&) noexcept;

std::string describeFindings(const std::vector<Finding>&, bool as_json);

// Prints them. Exit status 0 without problems, 1 with.
int doctor(const DoctorOptions&) noexcept;

// The process that examine() starts for what may hang or die: "runtime" or "vulkan". Prints a line of JSON
// for each step it is about to take and for each finding. The exit status is of no meaning.
int probe(const std::string& what, std::chrono::milliseconds patience);

// What it printed, whatever else stands there: its findings, and the step it was in when it ended.
std::string takeProbeLines(const std::vector<std::string>& lines, std::vector<Finding>&);

}  // namespace stylet::trainer
