// What the trainer asks of the operating system; the frames set an environment besides.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptics/loop.h"

namespace stylet::trainer {

// CLOCK_MONOTONIC with absolute sleeps.
haptics::Clock monotonicClock() noexcept;
// The processor time of the calling thread: times work, whatever else the machine does. It cannot sleep.
haptics::Clock workClock() noexcept;

// SCHED_FIFO's, below the kernel's threaded interrupts (50): a device's packets come through those.
inline constexpr int kRealTimePriority = 49;
// The limits that allow it, as in packaging/debian/stylet, and what a user without them does.
inline constexpr const char* kPriorityRight = "rtprio 49";
inline constexpr const char* kMemoryRight = "memlock unlimited";
std::string howToAllow(const std::vector<std::string>& rights);

// Gives the calling thread SCHED_FIFO and locks its memory. Returns an empty text, or one line that says what
// was refused and how to allow it.
std::string askForRealTime();

// From now on whatever ends or stops a program from its terminal (Ctrl-C, Ctrl-\, Ctrl-Z, hanging up) and
// SIGTERM ask it to end; the same a second time is obeyed at once. `interrupted` says whether it was asked.
void catchInterrupts() noexcept;
bool interrupted() noexcept;

// Adds what has been typed since the last call, without waiting, 4 KiB at most. False once stdin has ended.
bool takeTyped(std::string& text);

// A person watches what is written to stderr.
bool stderrIsWatched() noexcept;

// Makes a folder that can be written to. Throws patient::DataError that names it, `what` it is for and the
// reason.
void needFolder(const std::filesystem::path& folder, const std::string& what);

// An environment variable, empty when unset.
std::string environment(const char* name);
void setEnvironment(const char* name, const std::string& value);

// Tells this build of the program from every other: the linker's build id. 0 where it left none.
std::uint64_t buildMark() noexcept;
// Of this run of the program: no other has it meanwhile.
std::uint64_t processNumber() noexcept;

// $XDG_CACHE_HOME/stylet, or ~/.cache/stylet.
std::filesystem::path cacheFolder();
// $XDG_DATA_HOME/stylet, or ~/.local/share/stylet: what is not to be lost.
std::filesystem::path dataFolder();

}  // namespace stylet::trainer
