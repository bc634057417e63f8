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

// ---- Of a drainage.

// A finger on the space between the ribs, on the rib above it and on the rib below it.
Stages palpation() {
    return {take(Tool::finger),
            move({.deeper_m = 0.005}, 0.040),
            wait(0.4),
            move({.deeper_m = 0.005, .headward_m = 0.038}, 0.040),
            move({.deeper_m = 0.005, .headward_m = -0.038}, 0.040),
            move({.deeper_m = 0.005}, 0.060),
            move(kAir, 0.080)};
}
Stage numb(double ml) {
    return {.kind = StageKind::numb, .seconds = ml, .injected_m3_per_s = 1e-6};
}
// Just enough local anaesthetic at both ends of a track beside the path, or on it.
Stages numbTrack(double headward_m, double frontward_m) {
    const auto aside = [&](Place place) {
        place.headward_m = headward_m, place.frontward_m = frontward_m;
        return place;
    };
    return {move(aside(kAir), 0.080),
            move(aside({.deeper_m = 0.004}), 0.040),
            numb(0.6),
            move(aside({.share = 1.0, .deeper_m = -0.003, .to_capsule = true}), 0.030),
            numb(2.1),
            move(aside(kAir), 0.080)};
}
// Ten tracks and 27 ml, which is no overdose.
Stages numbEverywhere() {
    Stages stages{take(Tool::needle), hold()};
    for (const double headward_m : {0.012, 0.006, 0.0, -0.006, -0.012})
        for (const double frontward_m : {0.006, -0.006})
            stages = stages + numbTrack(headward_m, frontward_m);
    return stages;
}
// All steps before the puncture but the one that needs a picture.
Stages preparation() {
    return palpation() + Stages{take(Tool::needle), hold()} + numbTrack(0.0, 0.0) + cut(0.002) +
           Stages{Stage{.kind = StageKind::breathe}};
}
// The needle goes along the path without any picture.
Stages blindPuncture(double share) {
    return {take(Tool::needle),
            hold(),
            move({.share = share, .deeper_m = 0.001}, 0.012),
            wait(0.3),
            {.kind = StageKind::aspirate}};
}
// With wire, dilator and drain in the hand, the tool moves by as much as the hand.
Stages dilate() {
    return {take(Tool::dilator), move({.share = 1.0, .deeper_m = -0.035}), wait(1.0),
            move({.deeper_m = -0.080}, 0.040)};
}
Stages drainOverWire(const Stages& dilation = dilate()) {
    return Stages{take(Tool::wire),
                  move({.share = 1.0, .deeper_m = 0.090}),
                  take(Tool::needle),
                  move({.deeper_m = -0.040}, 0.060),
                  {.kind = StageKind::breathe}} +
           dilation +
           Stages{take(Tool::drain), move({.share = 1.0, .deeper_m = -0.025}), take(Tool::wire),
                  move({.deeper_m = -0.200}, 0.060)} +
           contrastUnderXrays();
}
Stages withForce(Stages stages) {
    for (Stage& stage : stages)
        if (stage.kind == StageKind::move) stage.speed_m_s = 0.4;
    return stages;
}
Stages cheapSteps() {
    Stages stages;
    for (int n = 0; n < 4; ++n)
        stages = stages + preparation() +
                 Stages{{.kind = StageKind::aspirate},
                        {.kind = StageKind::pedal, .pedal_down = true},
                        wait(0.5),
                        {.kind = StageKind::pedal, .pedal_down = false},
                        take(Tool::probe),
                        wait(1.5),
                        {.kind = StageKind::park}};
    return stages;
}

using Table = std::vector<std::pair<std::string, Stages>>;

Table punctureCheats() {
    return {
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
}

Table drainageCheats() {
    return {
        {"X-rays, contrast medium in the air and waiting", contrastUnderXrays() + Stages{wait(40.0)}},
        {"syringes, wire, dilator and drain in the air", Stages{take(Tool::needle),
                                                                numb(3.0),
                                                                {.kind = StageKind::aspirate},
                                                                take(Tool::wire),
                                                                take(Tool::dilator),
                                                                take(Tool::drain)} +
                                                             contrastUnderXrays()},
        {"numb everywhere, and no puncture", numbEverywhere()},
        {"cheap steps again and again", cheapSteps()},
        {"no anaesthesia and no ultrasound", blindPuncture(1.0) + contrastUnderXrays() + drainOverWire()},
        {"all but the ultrasound",
         preparation() + blindPuncture(1.0) + contrastUnderXrays() + drainOverWire()},
        {"a drain beside the duct",
         preparation() + blindPuncture(0.85) + contrastUnderXrays() + drainOverWire()},
        {"the duct hit, the wire in the parenchyma", preparation() + blindPuncture(1.0) +
                                                         contrastUnderXrays() + Stages{move({.share = 0.8})} +
                                                         drainOverWire()},
        {"force in place of the dilator", withForce(blindPuncture(1.0) + drainOverWire({}))},
    };
}

}  // namespace

std::vector<Cheat> makeCheats(training::Course course) {
    std::vector<Cheat> cheats;
    for (const auto& [name, stages] :
         course == training::Course::puncture ? punctureCheats() : drainageCheats()) {
        trainer::Scenario scenario;
        scenario.name = name;
        scenario.course = course;
        scenario.tool = Tool::finger;
        scenario.start = kAir;
        scenario.stages = stages;
        cheats.push_back({name, scenario});
    }
    return cheats;
}

}  // namespace stylet::test
