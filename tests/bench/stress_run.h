// One case of the campaign run through the very tick that the trainer runs, on a virtual clock.
#pragma once

#include "tests/bench/stress_case.h"
#include "tests/bench/stress_measures.h"

namespace stylet::stress {

CaseResult runCase(const StressCase&, const Tissues&, bool controller, double seconds = kCase_s);

// A hand that wants to stay where it is, 30 mm deep in a breathing liver: what it feels of the breath, the
// most of its force less the least over whole breaths, with the controller and without.
struct StillHand {
    const char* device = "";
    int rate_hz = 1000;
    bool rigid = false;  // nothing moves it; otherwise the firm hand
    double on_n = 0.0, off_n = 0.0;
    double apart_n = 0.0;  // the most that the two forces differ in a tick
    // A fiftieth is less than a hand tells apart in force (7 to 10 %: Jones 2000).
    bool fails() const { return !(off_n > 0.0) || on_n < 0.98 * off_n || apart_n > 0.02 * off_n; }
};
std::vector<StillHand> stillHands(const Tissues&);

}  // namespace stylet::stress
