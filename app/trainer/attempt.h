// All that is known of an attempt before its first tick.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/trainer/derived.h"
#include "app/trainer/registration_store.h"
#include "app/trainer/scenario.h"
#include "haptics/trace.h"
#include "patient/planning.h"

namespace stylet::trainer {

struct Attempt {
    const patient::Patient& patient;
    haptics::SimulationSettings simulation;
    haptics::Trace hand;                          // empty: the user's
    std::optional<haptics::TouchMap> touch;       // where a tool is taken that presses on the skin
    std::vector<haptics::TickInput> beginning{};  // of another attempt, computed before the hand takes over

    // How much of the attempt that is.
    std::int64_t begun_ns() const noexcept;
    const haptics::TouchMap* touchMap() const noexcept { return touch ? &*touch : nullptr; }
};

haptics::TouchMap makeTouch(const patient::Patient&);  // anew

// How a patient breathes in a scenario.
patient::BreathPlan breathPlan(const patient::Package&, const ScenarioBreath&, std::uint64_t seed);

// The scenario's hand along `path`, its device beside the patient. The period of a tick is `rate_hz`'s, in
// whole nanoseconds.
Attempt makeAttempt(const patient::Patient&, const Scenario&, const patient::PlannedPath& path,
                    std::uint64_t seed, double rate_hz = 1000.0, const MakeTouch& = makeTouch);
// The user's hand: no trace, every tool to be taken up, and the device stands so that its +z is out of the
// body along the path, which begins near that end of its workspace; where that is not known, as beside the
// patient, with the path's middle where the grip is (`device_from_grip`, once it is ready). A device whose
// place in the room is registered has the patient level. Throws where the device is slower than the
// controller accounts for.
Attempt makeLiveAttempt(const patient::Patient&, const Scenario&, const patient::PlannedPath& path,
                        std::uint64_t seed, haptics::TouchMap, const haptics::DeviceProfile&,
                        const patient::Pose& device_from_grip, double rate_hz = 1000.0,
                        const std::optional<Registration>& registration = {});

}  // namespace stylet::trainer
