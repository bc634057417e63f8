// The scripted trainee: input that follows a scenario along a planned path.
#pragma once

#include <cstdint>

#include "app/trainer/attempt/scenario.h"
#include "app/trainer/attempt/tool_pose.h"
#include "haptics/loop/trace.h"
#include "patient/planning/planning.h"

namespace stylet::trainer {

// Deterministic: the same scenario, path and seed give the same trace, bit for bit. After a breath-hold
// command the script waits for the longest possible breath. One sample per millisecond, in the device
// frame. `capsule_m`: depth of the liver's capsule along the path.
// Starts and stops follow the minimum-jerk step (Flash and Hogan 1985). Physiological tremor is the sum of
// three sines per axis between the scenario's frequencies (8-12 Hz, about 0.1 mm: Elble and Koller 1990).
haptics::Trace makeScriptedTrace(const Scenario&, const patient::PlannedPath&, double longest_breath_s,
                                 const haptics::SimulationSettings&, std::uint64_t seed,
                                 double capsule_m = 0.0);

// patient_from_device of a device beside the patient's right flank. Its +z points toward the trainee, its +y
// up.
Pose placeDeviceBeside(const Grid&);

}  // namespace stylet::trainer
