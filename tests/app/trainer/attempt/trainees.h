// Six scripted trainees of each course, from the expert to a reckless one.
#pragma once

#include <vector>

#include "app/trainer/attempt/scenario.h"

namespace stylet::test {

// From the best to the worst. Those of a puncture are shipped scenarios. Those of a drainage puncture in the
// same way and go on from there.
std::vector<trainer::Scenario> makeTrainees(training::Course);

}  // namespace stylet::test
