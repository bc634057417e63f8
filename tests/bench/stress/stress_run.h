// Runs one case of the campaign through the trainer's own haptics tick, on a virtual clock.
#pragma once

#include "tests/bench/stress/stress_case.h"
#include "tests/bench/stress/stress_measures.h"

namespace stylet::stress {

CaseResult runCase(const StressCase&, const Tissues&, bool controller, double seconds = kCase_s);

// A hand that tries to stay still with the needle 30 mm deep in a breathing liver. Measures the force range
// (maximum minus minimum) over whole breaths, with and without the controller.
struct StillHand {
    const char* device = "";
    int rate_hz = 1000;
    bool rigid = false;  // an immovable hand; otherwise the firm hand
    double on_n = 0.0, off_n = 0.0;
    double apart_n = 0.0;  // largest difference of the two forces in a tick
    // 2 % is less than the force difference that a hand can notice (7 to 10 %: Jones 2000).
    bool fails() const { return !(off_n > 0.0) || on_n < 0.98 * off_n || apart_n > 0.02 * off_n; }
};
std::vector<StillHand> stillHands(const Tissues&);

}  // namespace stylet::stress
