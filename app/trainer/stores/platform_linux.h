// Operating-system services of the trainer. The frame loop also sets environment variables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptics/loop/loop.h"

namespace stylet::trainer {

// CLOCK_MONOTONIC with absolute sleeps.
haptics::Clock monotonicClock() noexcept;
// CPU time of the calling thread, to measure work independently of other load. This clock cannot sleep.
haptics::Clock workClock() noexcept;

// SCHED_FIFO priority. It is lower than that of the kernel's threaded interrupts (50), which deliver a
// device's packets.
inline constexpr int kRealTimePriority = 49;
// Limits that permit real-time scheduling and locked memory, as in packaging/debian/stylet.
// describeHowToAllow() explains how to get them.
inline constexpr const char* kPriorityRight = "rtprio 49";
inline constexpr const char* kMemoryRight = "memlock unlimited";
std::string describeHowToAllow(const std::vector<std::string>& rights);

// Requests SCHED_FIFO for the calling thread and locks the memory of the process. Returns an empty string, or
// one line: what was refused, and how to allow it.
std::string requestRealTime();

// After this call, Ctrl-C, Ctrl-\, Ctrl-Z, a hangup and SIGTERM only request the program to end. A second
// signal of the same kind has its default effect. interrupted() returns true once the end was requested.
void catchInterrupts() noexcept;
bool interrupted() noexcept;

// Appends the text typed since the last call, at most 4 KiB, without waiting. Reads nothing while this
// process is in the background of its terminal. Returns false once stdin has ended.
bool readTyped(std::string& text);

// True if stderr is a terminal.
bool stderrIsTerminal() noexcept;

// Value of an environment variable; empty if unset.
std::string environment(const char* name);
void setEnvironment(const char* name, const std::string& value);

// Identifies this build of the program: hash of the linker's build id. 0 if there is none.
std::uint64_t buildId() noexcept;
// Process id: unique among the running processes.
std::uint64_t processId() noexcept;

// Folders of the user. As in the XDG Base Directory Specification, a variable with a relative path is
// ignored. Without a home folder both are /tmp/stylet, or the same in $TMPDIR. $XDG_CACHE_HOME/stylet, or
// ~/.cache/stylet.
std::filesystem::path cacheFolder();
// $XDG_DATA_HOME/stylet, or ~/.local/share/stylet: data that must not be lost.
std::filesystem::path dataFolder();
// True if the data folder is in the temporary folder, because no variable names another.
bool isDataTemporary();

}  // namespace stylet::trainer
