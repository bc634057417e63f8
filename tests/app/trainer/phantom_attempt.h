// An attempt on layers with known borders: skin, fat, fascia and liver with a duct inside.
#pragma once

#include "app/trainer/loop/loops.h"
#include "tests/app/trainer/assets.h"
#include "tests/support/duct_path.h"
#include "tests/support/phantom.h"

namespace stylet::test {

// Borders at x = 0, 2, 20, 22, 50 and 56 mm. The path runs along +x to the centre of the duct.
inline patient::Package ductPhantom() {
    using patient::Tissue;
    patient::Package package = makeSlabs({{Tissue::skin, 0.002},
                                          {Tissue::soft, 0.018},
                                          {Tissue::fascia, 0.002},
                                          {Tissue::liver, 0.028},
                                          {Tissue::duct, 0.006},
                                          {Tissue::liver, 0.020}},
                                         0.001);
    package.signal.period_s = 1.0;
    return package;
}

inline trainer::Scenario shortScenario() {
    return trainer::loadScenario(testScenario("short"));
}

// One finished attempt and the log of its session.
struct Played {
    trainer::SessionLog log;
    trainer::LoopTotals totals;
};

inline Played playFast(const patient::Package& package, const trainer::Scenario& scenario,
                       std::uint64_t seed) {
    const patient::Patient patient(package);
    const trainer::Attempt attempt = trainer::makeAttempt(patient, scenario, ductPath(), seed);
    trainer::Session session(patient, ductPath(), scenario.moments, scenario.approach_distance_m, nullptr);
    const trainer::LoopTotals totals = trainer::runFast(attempt, session, nullptr, 0.0, {});
    return {session.log(), totals};
}

}  // namespace stylet::test
