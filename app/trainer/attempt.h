// All that is known of an attempt before its first tick.
#pragma once

#include <cstdint>

#include "app/trainer/scenario.h"
#include "haptics/trace.h"
#include "patient/planning.h"

namespace stylet::trainer {

struct Attempt {
    const patient::Patient& patient;
    haptics::SimulationSettings simulation;
    haptics::Trace hand;
};

// The scenario's hand along `path`, its device beside the patient.
Attempt makeAttempt(const patient::Patient&, const Scenario&, const patient::PlannedPath& path,
                    std::uint64_t seed);

}  // namespace stylet::trainer
