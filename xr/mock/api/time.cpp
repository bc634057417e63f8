// XR_KHR_convert_timespec_time: converts between XrTime and timespec (a CLOCK_MONOTONIC time).
// Real clock: XrTime is the CLOCK_MONOTONIC time in nanoseconds.
// Virtual clock: XrTime is the virtual time since xrCreateInstance. Its timespec is the CLOCK_MONOTONIC time
// of xrCreateInstance plus XrTime.
#include <limits>

#include "api/api.h"
#include "world/objects.h"
#include "world/verify.h"

namespace xrmock {

namespace {

constexpr std::int64_t kPerSecond = 1'000'000'000;

std::int64_t monotonicOrigin(const Instance& instance) {
    return instance.clock.is_virtual ? instance.created_ns : 0;
}

}  // namespace

XrResult convertTimespecTimeToTime(Call& call, XrInstance handle, const timespec* given, XrTime* time) {
    const Instance& instance = call.live<Instance>(handle);
    requireValid(given != nullptr && time != nullptr, "an argument is null");
    requireValid(given->tv_nsec >= 0 && given->tv_nsec < kPerSecond, "tv_nsec is not below a second");
    constexpr std::int64_t kMaxSeconds = std::numeric_limits<std::int64_t>::max() / kPerSecond - 1;
    require(given->tv_sec >= 0 && given->tv_sec <= kMaxSeconds, XR_ERROR_TIME_INVALID,
            "the time is before or beyond every XrTime");
    const std::int64_t result = given->tv_sec * kPerSecond + given->tv_nsec - monotonicOrigin(instance);
    requireTime(result);
    *time = result;
    return XR_SUCCESS;
}

XrResult convertTimeToTimespecTime(Call& call, XrInstance handle, XrTime time, timespec* out) {
    const Instance& instance = call.live<Instance>(handle);
    requireValid(out != nullptr, "timespecTime is null");
    requireTime(time);
    const std::int64_t origin_ns = monotonicOrigin(instance);
    require(time <= std::numeric_limits<std::int64_t>::max() - origin_ns, XR_ERROR_TIME_INVALID,
            "the time is beyond every timespec");
    const std::int64_t monotonic_ns = time + origin_ns;
    *out = {monotonic_ns / kPerSecond, monotonic_ns % kPerSecond};
    return XR_SUCCESS;
}

}  // namespace xrmock
