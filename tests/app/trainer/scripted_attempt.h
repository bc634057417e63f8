// Plays a scripted attempt in this process, on the virtual clock: the ticks of `stylet run --fast`, without
// its record and its result files. A drainage draws its case.
#pragma once

#include "app/trainer/loop/loops.h"

namespace stylet::test {

inline trainer::SessionLog playScripted(const patient::Patient& patient, const haptics::TouchMap& touch,
                                        const patient::PlannedPath& path, const trainer::Scenario& scenario,
                                        std::uint64_t seed) {
    trainer::Scenario played = scenario;
    trainer::drawCase(played, seed);
    const trainer::Attempt attempt = trainer::makeAttempt(
        patient, played, path, seed, 1000.0, [&touch](const patient::Patient&) { return touch; });
    trainer::Session session(patient, path, scenario.moments, scenario.approach_distance_m, nullptr);
    session.setCourse(scenario.course);
    session.setCase(played.patient_case);
    trainer::runFast(attempt, session, nullptr, 0.0, {});
    return session.log();
}

}  // namespace stylet::test
