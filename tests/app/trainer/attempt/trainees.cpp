#include "tests/app/trainer/attempt/trainees.h"

#include <algorithm>

#include "tests/app/trainer/assets.h"

namespace stylet::test {

namespace {

using haptics::Tool;
using trainer::Scenario;
using trainer::Stage;
using trainer::StageKind;
using Stages = std::vector<Stage>;

Scenario shipped(const std::string& name) {
    return trainer::loadScenario(assets() / "scenarios" / (name + ".toml"));
}

auto takes(Tool tool) {
    return [tool](const Stage& s) { return s.kind == StageKind::changeTool && s.tool == tool; };
}
auto movesPedal(bool down) {
    return [down](const Stage& s) { return s.kind == StageKind::pedal && s.pedal_down == down; };
}

// Two parts of the expert's drainage: the local anaesthesia, and all from the wire on.
struct DrainageParts {
    Stages anaesthesia, access;
};
DrainageParts splitDrainage(const Stages& expert) {
    const auto needle = std::ranges::find_if(expert, takes(Tool::needle));
    const auto scalpel = std::find_if(needle, expert.end(), takes(Tool::scalpel));
    const auto wire = std::find_if(scalpel, expert.end(), takes(Tool::wire));
    return {{needle, scalpel}, {wire, expert.end()}};
}

// Goes on from the trainee's last move to the target, in place of what the trainee does there in a puncture.
// Only a thorough trainee reads the case, numbs the track, draws bile and makes pictures.
Scenario makeDrainage(Scenario scenario, const DrainageParts& parts, bool thorough) {
    scenario.course = training::Course::drainage;
    Stages& stages = scenario.stages;
    const auto in_target = std::find_if(stages.rbegin(), stages.rend(), [](const Stage& s) {
                               return s.kind == StageKind::move && s.to.share == 1.0;
                           }).base();
    Stages access = parts.access;
    if (thorough) {
        const auto picture = std::find_if(in_target, stages.end(), movesPedal(true));
        stages.erase(std::find_if(picture, stages.end(), movesPedal(false)) + 1, stages.end());
        stages.insert(picture, Stage{.kind = StageKind::aspirate});
        stages.push_back({.kind = StageKind::pedal, .pedal_down = true});
        const auto scalpel = std::ranges::find_if(stages, takes(Tool::scalpel));
        stages.insert(scalpel, parts.anaesthesia.begin(), parts.anaesthesia.end());
    } else {
        stages.erase(in_target, stages.end());
        stages.push_back({.kind = StageKind::wait, .seconds = 0.5});
        std::erase_if(
            access, [](const Stage& s) { return s.kind == StageKind::inject || s.kind == StageKind::pedal; });
    }
    stages.insert(stages.end(), access.begin(), access.end());
    stages.insert(stages.begin(),
                  Stage{.kind = StageKind::review,
                        .answers = thorough ? trainer::ReviewAnswers::right : trainer::ReviewAnswers::yes});
    return scenario;
}

}  // namespace

std::vector<Scenario> makeTrainees(training::Course course) {
    std::vector<Scenario> trainees;
    for (const char* name : {"procedure", "trainee-good", "trainee-hesitant", "trainee-sloppy",
                             "trainee-careless", "trainee-reckless"})
        trainees.push_back(shipped(name));
    if (course == training::Course::puncture) return trainees;
    constexpr std::size_t kThorough = 3;  // up to the hesitant one
    trainees.front() = shipped("drainage");
    const DrainageParts parts = splitDrainage(trainees.front().stages);
    for (std::size_t who = 1; who < trainees.size(); ++who)
        trainees[who] = makeDrainage(trainees[who], parts, who < kThorough);
    return trainees;
}

}  // namespace stylet::test
