// Calls that the scenario refuses or delays.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scenario/scenario_events.h"

namespace xrmock {

class Call;

struct Fault {
    Refusal refusal;
    std::int64_t until_ns = 0;  // end of a refusal with a duration
    std::uint64_t calls = 0;    // calls of its function so far
};

// Returns the scripted error for this call, if any. The faults are those of the instance that owns
// `handle`. The refusal is reported to the debug messengers.
std::optional<XrResult> scriptedRefusal(Call& call, std::uint64_t handle);
// Sleeps without the lock if the scenario stalls this call.
void stallIfScripted(Call& call, std::uint64_t handle);

}  // namespace xrmock
