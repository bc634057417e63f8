// The runtime's time and ours, CLOCK_MONOTONIC (XR_KHR_convert_timespec_time). Any thread.
#pragma once

#include "xr/instance.h"

namespace stylet::xr {

// Both give nothing without the extension, and for times the runtime refuses.
std::optional<XrTime> runtimeTimeOf(const Instance&, std::int64_t monotonic_ns);
std::optional<std::int64_t> monotonicTimeOf(const Instance&, XrTime);

}  // namespace stylet::xr
