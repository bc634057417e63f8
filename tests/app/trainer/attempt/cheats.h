// Ways to cheat an exam. Each plays what a person could do with mouse, keys and a copy of the planned path:
// the hand goes along the path without error, but leaves out what needs skill.
#pragma once

#include <string>
#include <vector>

#include "app/trainer/attempt/scenario.h"

namespace stylet::test {

struct Cheat {
    std::string name;
    trainer::Scenario scenario;
};
std::vector<Cheat> makeCheats(training::Course);

}  // namespace stylet::test
