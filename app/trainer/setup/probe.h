// Checks that may hang or crash. They run in a child process (doctor.h).
#pragma once

#include <functional>
#include <string>

#include "app/trainer/setup/doctor.h"

namespace stylet::trainer {

struct ProbeReport {
    std::function<void(const std::string& step)> about;  // called before each step
    std::function<void(const Finding&)> found;
};

// Checks the loader, the runtime, the headset, its graphics device and, as far as possible, a session.
// Converts an exception to a finding. Waits for the session to begin and to become visible, each for at most
// a fraction of `patience`.
void probeRuntime(const ProbeReport&, std::chrono::milliseconds patience);
// Checks the graphics card without an OpenXR runtime.
void probeVulkan(const ProbeReport&);

}  // namespace stylet::trainer
