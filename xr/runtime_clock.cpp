#include "xr/runtime_clock.h"

namespace stylet::xr {
namespace {

constexpr std::int64_t kPerSecond = 1'000'000'000;

}  // namespace

std::optional<XrTime> toRuntimeTime(const Instance& instance, std::int64_t monotonic_ns) {
    if (!instance.calls.convertTimespecTimeToTime) return std::nullopt;
    const timespec given{monotonic_ns / kPerSecond, monotonic_ns % kPerSecond};
    XrTime time = 0;
    if (XR_FAILED(instance.calls.convertTimespecTimeToTime(instance.handle.get(), &given, &time)))
        return std::nullopt;
    return time;
}

std::optional<std::int64_t> toMonotonicTime(const Instance& instance, XrTime time) {
    if (!instance.calls.convertTimeToTimespecTime) return std::nullopt;
    timespec found{};
    if (XR_FAILED(instance.calls.convertTimeToTimespecTime(instance.handle.get(), time, &found)))
        return std::nullopt;
    return std::int64_t(found.tv_sec) * kPerSecond + found.tv_nsec;
}

}  // namespace stylet::xr
