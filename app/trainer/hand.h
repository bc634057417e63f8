// The scripted trainee: a hand that follows a scenario along a planned path.
#pragma once

#include <cstdint>

#include "app/trainer/scenario.h"
#include "haptics/trace.h"
#include "patient/planning.h"

namespace stylet::trainer {

// The same scenario, path and seed give the same trace, bit for bit. A commanded hold is waited for as long
// as the longest breath lasts. One sample a millisecond, device frame.
// Starts and stops follow the minimum-jerk step (Flash and Hogan 1985); physiological tremor is three sines
// an axis between the scenario's frequencies (8-12 Hz, about 0.1 mm: Elble and Koller 1990).
haptics::Trace scriptHand(const Scenario&, const patient::PlannedPath&, double longest_breath_s,
                          const haptics::SimulationSettings&, std::uint64_t seed);

// Where a device would stand: beside the patient's right flank, its +z toward the trainee, +y up.
patient::Pose deviceBeside(const patient::Grid&);

// How a tool is held where a needle would be held so: like it, but a probe so that its guide's line is the
// needle's, its face where the tip would be.
patient::Pose heldLike(const patient::Pose& patient_from_needle, haptics::Tool,
                       const haptics::GuideSettings&);

// Needle pose with the tip at `tip_m` and the shaft pointing INTO the body along `axis` (unit).
patient::Pose needlePose(const patient::Vec3& tip_m, const patient::Vec3& axis);

}  // namespace stylet::trainer
