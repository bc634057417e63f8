// Conversion between the runtime's time and CLOCK_MONOTONIC (XR_KHR_convert_timespec_time). Any thread.
#pragma once

#include "xr/instance.h"

namespace stylet::xr {

// Both return nullopt without the extension, and for times that the runtime refuses.
std::optional<XrTime> toRuntimeTime(const Instance&, std::int64_t monotonic_ns);
std::optional<std::int64_t> toMonotonicTime(const Instance&, XrTime);

}  // namespace stylet::xr
