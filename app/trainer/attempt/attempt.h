// Everything that is fixed before an attempt's first tick.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "app/trainer/attempt/config.h"
#include "app/trainer/attempt/scenario.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/stores/derived.h"
#include "app/trainer/stores/registration_store.h"
#include "haptics/loop/trace.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

struct Attempt {
    const patient::Patient& patient;
    haptics::SimulationSettings simulation;
    haptics::Trace hand;                          // scripted input; empty: live input
    std::optional<haptics::TouchMap> touch;       // set if a tool of this attempt presses on the skin
    std::optional<patient::DuctSpace> ducts{};    // set if this attempt uses the guide wire
    std::vector<haptics::TickInput> beginning{};  // recorded ticks of an earlier attempt; computed first

    // Duration of `beginning`.
    std::int64_t begun_ns() const noexcept;
    const haptics::TouchMap* touchMap() const noexcept { return touch ? &*touch : nullptr; }
    const patient::DuctSpace* ductSpace() const noexcept { return ducts ? &*ducts : nullptr; }
};

// Gives a new attempt the force settings of its instruments. Call it before the first tick. An attempt that
// begins with a record has the recorded settings instead.
void equip(Attempt&, const haptics::ToolSettings&);

haptics::TouchMap makeTouch(const patient::Patient&);  // Computes the touch map without a cache.

// The patient's breathing signal with the scenario's breath settings applied.
patient::BreathPlan breathPlan(const patient::Package&, const ScenarioBreath&, std::uint64_t seed);

// Makes an attempt with scripted input along `path`. The device stands beside the patient. The tick period is
// 1 / `rate_hz`, rounded to whole nanoseconds.
Attempt makeAttempt(const patient::Patient&, const Scenario&, const patient::PlannedPath& path,
                    std::uint64_t seed, double rate_hz = 1000.0, const MakeTouch& = makeTouch);
// The input device of a live attempt, once it is ready.
struct LiveDeviceFacts {
    haptics::DeviceProfile profile{};
    Pose device_from_grip{};
    std::optional<Registration> registration{};
};

// Makes an attempt with live input: no trace, and every tool may be used. Uses the seed and the rate of the
// configuration.
// Device placement: with a `registration`, the patient lies level in the room. Otherwise, if the device's
// workspace is known, the device's +z points out of the body along the path, and the path begins near that
// end of the workspace. Otherwise the device stands beside the patient with the middle of the path at the
// grip.
// In an exam its axes are the room's: x toward the patient's feet, y front, z toward the operator. The middle
// of its workspace lies between flank and liver if the path is within reach from there, and otherwise where
// the seed puts it: the user must not be able to push along an axis of the device instead of using the
// pictures. A device that does not sense rotation always holds the needle along the path
// (haptics/devices/clutch.h); liveAttempt() refuses it.
// Throws EnvironmentError if the device's latency exceeds the controller's limit (haptics::kMaxDelayTicks).
Attempt makeLiveAttempt(const patient::Patient&, const Scenario&, const patient::PlannedPath& path,
                        const OperativeField&, const AttemptConfig&, haptics::TouchMap,
                        const LiveDeviceFacts&);

}  // namespace stylet::trainer
