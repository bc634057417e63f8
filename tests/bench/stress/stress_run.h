// Runs one case of the campaign through the trainer's own haptics tick, on a virtual clock.
#pragma once

#include "tests/bench/stress/stress_case.h"
#include "tests/bench/stress/stress_measures.h"

namespace stylet::stress {

CaseResult runCase(const StressCase&, const Tissues&, bool controller, double seconds = kCase_s);

// Result for a hand that tries to stay still while the needle is 30 mm deep in a breathing liver. on_n and
// off_n are the force range (maximum minus minimum) over whole breaths, with and without the controller.
struct StillHand {
    const char* device = "";
    int rate_hz = 1000;
    bool rigid = false;  // the hand does not move at all; false: HandKind::firm
    double on_n = 0.0, off_n = 0.0;
    double apart_n = 0.0;  // largest difference between the two forces in any tick
    // The controller may reduce the range by 2 %, and change the force by 2 % of the range. A hand notices a
    // force difference of 7 to 10 % (Jones 2000).
    bool fails() const { return !(off_n > 0.0) || on_n < 0.98 * off_n || apart_n > 0.02 * off_n; }
};
std::vector<StillHand> stillHands(const Tissues&);

}  // namespace stylet::stress
