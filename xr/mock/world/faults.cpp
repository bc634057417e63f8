#include "world/faults.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "world/call.h"
#include "world/objects.h"

namespace xrmock {

namespace {

// Counts the call and returns whether to refuse it.
bool countAndMatch(Fault& fault, std::int64_t now_ns) {
    const Refusal& refusal = fault.refusal;
    ++fault.calls;
    if (refusal.for_s) return now_ns < fault.until_ns;
    return fault.calls >= refusal.nth && fault.calls - refusal.nth < refusal.times;
}

bool isExpired(const Fault& fault, std::int64_t now_ns) {
    const Refusal& refusal = fault.refusal;
    if (refusal.for_s) return now_ns >= fault.until_ns;
    return fault.calls >= refusal.nth && fault.calls - refusal.nth + 1 >= refusal.times;
}

}  // namespace

std::optional<XrResult> scriptedRefusal(Call& call, std::uint64_t handle) {
    Instance* instance = findInstance(runtime().handles.find(handle));
    if (instance == nullptr || instance->faults.empty()) return std::nullopt;
    const std::int64_t now_ns = instance->clock.now(call.now_ns);
    std::optional<XrResult> result;
    for (Fault& fault : instance->faults) {
        if (fault.refusal.function != call.function || !countAndMatch(fault, now_ns)) continue;
        if (!result) result = fault.refusal.result;
    }
    std::erase_if(instance->faults, [&](const Fault& fault) { return isExpired(fault, now_ns); });
    if (!result) return std::nullopt;
    call.subject = handle;
    reportRefusal(call, *result, "the scenario refuses this call");
    return result;
}

void stallIfScripted(Call& call, std::uint64_t handle) {
    Instance* instance = findInstance(runtime().handles.find(handle));
    if (instance == nullptr) return;
    auto& stalls = instance->stalls;
    const auto due = std::find_if(stalls.begin(), stalls.end(), [&](Stall& stall) {
        return stall.function == call.function && --stall.nth == 0;
    });
    if (due == stalls.end()) return;
    const std::chrono::duration<double> wait(due->for_s);
    stalls.erase(due);
    call.runUnlocked([&] {
        std::this_thread::sleep_for(wait);
        return true;
    });
}

}  // namespace xrmock
