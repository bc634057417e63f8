#include "tests/app/trainer/attempt/trainees.h"

#include <gtest/gtest.h>

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

// Of the expert's stages, from the first that passes `from` to before the next that passes `to`.
void leaveOut(Stages& stages, const auto& from, const auto& to) {
    const auto first = std::ranges::find_if(stages, from);
    stages.erase(first, std::find_if(first, stages.end(), to));
}

enum class Part : std::uint8_t {
    palpation,
    anaesthesia,
    incision,
    guide,
    bile,
    contrast,
    dilator,
    wholeDrain,
    finalPicture
};

void leaveOut(Stages& stages, Part part) {
    const auto injects = [](const Stage& s) { return s.kind == StageKind::inject; };
    const auto isKind = [](StageKind kind) { return [kind](const Stage& s) { return s.kind == kind; }; };
    switch (part) {
        case Part::palpation:
            leaveOut(stages, isKind(StageKind::move), takes(Tool::probe));
            break;
        case Part::anaesthesia:
            leaveOut(stages, takes(Tool::needle), takes(Tool::scalpel));
            break;
        case Part::incision:
            leaveOut(stages, takes(Tool::scalpel), isKind(StageKind::breathe));
            break;
        case Part::guide:
            std::erase_if(stages, takes(Tool::guide));
            break;
        case Part::bile:
            std::erase_if(stages, isKind(StageKind::aspirate));
            break;
        case Part::contrast:
            *std::ranges::find_if(stages, injects) = {.kind = StageKind::wait, .seconds = 0.5};
            break;
        case Part::dilator: {  // the drain begins where it would have begun
            const auto drain = std::ranges::find_if(stages, takes(Tool::drain));
            const Stage back = *(drain - 1);
            leaveOut(stages, takes(Tool::dilator), takes(Tool::drain));
            stages.insert(std::ranges::find_if(stages, takes(Tool::drain)), back);
            break;
        }
        case Part::wholeDrain:
            stages.erase(std::ranges::find_if(stages, takes(Tool::drain)), stages.end());
            break;
        case Part::finalPicture: {
            const auto last = std::find_if(stages.rbegin(), stages.rend(), injects);
            stages.erase(last.base() - 1);
            break;
        }
    }
}

}  // namespace

std::vector<Omission> makeOmissions(training::Course course) {
    using enum Part;
    struct Row {
        std::string left_out;
        std::vector<Part> parts;
        bool fails_exam = true;
    };
    const std::vector<Row> puncture{
        {"palpation", {palpation}, false},
        {"incision", {incision}, false},
        {"the guide", {guide}, false},
        {"contrast medium", {contrast}},
        {"palpation, incision, the guide and contrast medium", {palpation, incision, guide, contrast}}};
    const std::vector<Row> drainage{
        {"palpation", {palpation}, false},
        {"anaesthesia", {anaesthesia}},
        {"incision", {incision}, false},
        {"the guide", {guide}, false},
        {"bile", {bile}, false},
        {"the picture of the ducts", {contrast}, false},
        {"bile and the picture of the ducts", {bile, contrast}},
        {"the dilator", {dilator}},
        {"the drain", {wholeDrain}},
        {"the final picture", {finalPicture}},
        {"both pictures", {contrast, finalPicture}},
        {"palpation, anaesthesia, incision, bile and pictures",
         {palpation, anaesthesia, incision, bile, contrast, finalPicture}},
        {"all but the least that places a drain",
         {palpation, anaesthesia, incision, guide, bile, contrast, dilator, finalPicture}},
        {"all that an exam does not ask for", {palpation, incision, guide, contrast}, false}};
    const Scenario expert = makeTrainees(course).front();
    std::vector<Omission> all;
    for (const Row& row : course == training::Course::puncture ? puncture : drainage) {
        Omission omission{row.left_out, expert, row.fails_exam};
        for (const Part part : row.parts)
            leaveOut(omission.scenario.stages, part);
        all.push_back(std::move(omission));
    }
    return all;
}

Scenario withLighterProbe(Scenario scenario) {
    Stages& stages = scenario.stages;
    const auto probe = std::ranges::find_if(stages, takes(Tool::probe));
    const auto parked =
        std::find_if(probe, stages.end(), [](const Stage& s) { return s.kind == StageKind::park; });
    EXPECT_NE(parked, stages.end()) << scenario.name << " parks no probe";
    for (auto stage = probe; stage != parked; ++stage)
        if (stage->kind == StageKind::move && stage->to.deeper_m > 0.0) stage->to.deeper_m *= 0.5;
    return scenario;
}

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
