// What may hang or die, and is therefore asked in a process of its own (doctor.h).
#pragma once

#include <functional>
#include <string>

#include "app/trainer/doctor.h"

namespace stylet::trainer {

struct ProbeReport {
    std::function<void(const std::string& step)> about;  // to be taken next
    std::function<void(const Finding&)> found;
};

// Loader, runtime, headset, its graphics device, a session as far as it comes. Whatever they throw ends in a
// finding. A session that neither begins nor is shown is left after a good part of `patience`.
void probeRuntime(const ProbeReport&, std::chrono::milliseconds patience);
// The graphics card without any runtime.
void probeVulkan(const ProbeReport&);

}  // namespace stylet::trainer
