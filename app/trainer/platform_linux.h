// Everything the trainer asks of the operating system.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "haptics/loop.h"

namespace stylet::trainer {

// CLOCK_MONOTONIC with absolute sleeps.
haptics::Clock monotonicClock() noexcept;
// The processor time of the calling thread: times work, whatever else the machine does. It cannot sleep.
haptics::Clock workClock() noexcept;

// Gives the calling thread SCHED_FIFO and locks its memory. Returns an empty text, or one line that says what
// was refused and how to allow it.
std::string askForRealTime();

// A person watches what is written to stderr.
bool stderrIsWatched() noexcept;

// Folder of the running program.
std::filesystem::path programFolder();

// An environment variable, empty when unset.
std::string environment(const char* name);
void setEnvironment(const char* name, const std::string& value);

// $XDG_CACHE_HOME/stylet, or ~/.cache/stylet.
std::filesystem::path cacheFolder();

}  // namespace stylet::trainer
