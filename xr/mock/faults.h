// Calls that the scenario refuses, or makes wait.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scenario_events.h"

namespace xrmock {

class Call;

struct Fault {
    Refusal refusal;
    std::int64_t until_ns = 0;  // of a refusal that lasts for a time
    std::uint64_t calls = 0;    // of its function, so far
};

// The result that the call gets instead of being made: one of the faults of the instance that the handle
// belongs to. The reason is reported.
std::optional<XrResult> scriptedRefusal(Call& call, std::uint64_t handle);
// Waits without the lock if the call is one that the scenario stalls.
void stallIfScripted(Call& call, std::uint64_t handle);

}  // namespace xrmock
