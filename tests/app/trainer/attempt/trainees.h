// Six scripted trainees of each course, from the expert to a reckless one.
#pragma once

#include <string>
#include <vector>

#include "app/trainer/attempt/scenario.h"

namespace stylet::test {

// From the best to the worst. Those of a puncture are shipped scenarios. Those of a drainage puncture in the
// same way and go on from there.
std::vector<trainer::Scenario> makeTrainees(training::Course);

// The scenario with a probe that presses half as deep into the skin.
trainer::Scenario withLighterProbe(trainer::Scenario);

// The expert without one or several parts of the procedure.
struct Omission {
    std::string left_out;
    trainer::Scenario scenario;
    bool fails_exam = true;  // false: it costs points, and the exam only if something else goes wrong
};
std::vector<Omission> makeOmissions(training::Course);

}  // namespace stylet::test
