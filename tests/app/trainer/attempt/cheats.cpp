#include "tests/app/trainer/attempt/cheats.h"

namespace stylet::test {

namespace {

using haptics::Tool;
using trainer::Place;
using trainer::Stage;
using trainer::StageKind;
using Stages = std::vector<Stage>;

constexpr Place kAir{.deeper_m = -0.030}, kBeyondTarget{.share = 1.0, .deeper_m = 0.001};

Stage move(const Place& to, double speed_m_s = 0.020) {
    return {.kind = StageKind::move, .to = to, .speed_m_s = speed_m_s};
}
Stage take(Tool tool) {
    return {.kind = StageKind::changeTool, .seconds = 0.5, .tool = tool};
}
Stage wait(double seconds) {
    return {.kind = StageKind::wait, .seconds = seconds};
}
Stage hold() {
    return {.kind = StageKind::hold, .seconds = 0.3};
}

Stages operator+(Stages a, const Stages& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

Stages contrastUnderXrays() {
    return {{.kind = StageKind::pedal, .pedal_down = true},
            {.kind = StageKind::inject, .seconds = 4.0, .injected_m3_per_s = 0.8e-6},
            wait(1.0),
            {.kind = StageKind::pedal, .pedal_down = false}};
}
Stages punctureAndContrast() {
    return Stages{take(Tool::needle), hold(), move(kBeyondTarget, 0.012), wait(0.3)} + contrastUnderXrays() +
           Stages{move(kAir, 0.040), {.kind = StageKind::breathe}};
}
// Touches the skin with a tool for a moment.
Stages dab(Tool tool, double deeper_m) {
    return {take(tool), move({.deeper_m = deeper_m}, 0.040), wait(0.5), move(kAir, 0.080)};
}
Stages cut(double half_m) {
    return {take(Tool::scalpel), move({.deeper_m = 0.005, .frontward_m = -half_m}, 0.040),
            move({.deeper_m = 0.005, .frontward_m = half_m}, 0.020), move(kAir, 0.080)};
}

Stages manyPunctures() {
    Stages stages{take(Tool::needle), hold()};
    for (const double headward_m : {0.008, 0.004, -0.004, -0.008, 0.0})
        for (const double frontward_m : {0.006, -0.006, 0.0}) {
            Place from = kAir, to = kBeyondTarget;
            from.headward_m = to.headward_m = headward_m;
            from.frontward_m = to.frontward_m = frontward_m;
            stages = stages + Stages{move(from, 0.080), move(to, 0.060), move(from, 0.080)};
        }
    return stages + contrastUnderXrays();
}

}  // namespace

std::vector<Cheat> cheats() {
    const std::vector<std::pair<std::string, Stages>> all{
        {"tool keys, Home and the wheel",
         Stages{take(Tool::probe), take(Tool::scalpel), take(Tool::guide)} + punctureAndContrast()},
        {"the needle alone", {take(Tool::needle), move(kBeyondTarget, 0.015), wait(1.0), move(kAir, 0.040)}},
        {"a guide in mid-air", Stages{take(Tool::probe),
                                      move({.deeper_m = -0.025}, 0.040),
                                      {.kind = StageKind::park},
                                      move(kAir, 0.040),
                                      take(Tool::guide)} +
                                   punctureAndContrast()},
        {"X-rays and contrast medium only", contrastUnderXrays()},
        {"many punctures until one hits", manyPunctures()},
        {"waiting", {wait(40.0)}},
        {"steps left out", dab(Tool::finger, 0.005) + cut(0.002) + punctureAndContrast()},
        {"staying in the target",
         {take(Tool::needle), hold(), move(kBeyondTarget, 0.020), wait(20.0), move(kAir, 0.040)}},
        {"the breath held afterwards",
         Stages{take(Tool::needle), move(kBeyondTarget, 0.020), hold(), wait(2.0)} + contrastUnderXrays() +
             Stages{move(kAir, 0.040)}},
        {"the probe parked somewhere else",
         dab(Tool::finger, 0.005) +
             Stages{take(Tool::probe),
                    move({.deeper_m = 0.003, .headward_m = -0.045, .roll_rad = -0.6}, 0.040),
                    wait(2.0),
                    {.kind = StageKind::park},
                    move(kAir, 0.080)} +
             cut(0.002) + punctureAndContrast()},
        {"contrast medium beside the duct", Stages{take(Tool::needle), hold(), move({.share = 0.85}, 0.020)} +
                                                contrastUnderXrays() + Stages{move(kAir, 0.040)}},
        {"a cut across the flank", cut(0.040) + punctureAndContrast()},
    };
    std::vector<Cheat> cheats;
    for (const auto& [name, stages] : all) {
        trainer::Scenario scenario;
        scenario.name = name;
        scenario.tool = Tool::finger;
        scenario.start = kAir;
        scenario.stages = stages;
        cheats.push_back({name, scenario});
    }
    return cheats;
}

}  // namespace stylet::test
