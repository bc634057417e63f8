// stylet-tutor-pictures FOLDER [headset|window] [NAME]: pictures of a guided drainage, to look at: each act
// that the expert does, each refusal, and each notice of the syringe, in the headset (mock runtime) and in
// the window (Xvfb). NAME: only pictures whose name contains it. Uses a synthetic patient.
#include <fmt/core.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "app/report/canvas.h"
#include "app/trainer/attempt/demonstration.h"
#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/session/session.h"
#include "app/trainer/view/pictures.h"
#include "app/training/tutor.h"
#include "haptics/devices/replay.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSettled_ticks = 120;  // of an act, before its picture
constexpr int kEyePixels = 900;

struct Scene {
    patient::Package package;
    patient::Patient patient{package};
    patient::PlannedPath path;
    haptics::TouchMap touch;
};

patient::Package drawnPatient() {
    patient::synth::SynthSettings settings;
    settings.seed = 4;
    settings.spacing_m = 0.002;
    settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
    return patient::synth::makeReferencePatient(settings);
}

// The states of the expert's drainage at which each act is asked for.
std::vector<Capture> actsOf(const Scene& scene) {
    const Scenario scenario = loadScenario(test::assets() / "scenarios" / "drainage.toml");
    const Attempt attempt = makeAttempt(scene.patient, scenario, scene.path, 1, 1000.0,
                                        [&](const patient::Patient&) { return scene.touch; });
    haptics::Simulation simulation(scene.patient, attempt.simulation, attempt.touchMap(),
                                   attempt.ductSpace());
    haptics::ReplayDevice device(attempt.hand, 0, attempt.simulation.profile);
    Session session(scene.patient, scene.path, {}, 0.0, nullptr);
    session.setCourse(training::Course::drainage);
    session.setDifficulty(training::Difficulty::guided);
    std::vector<Capture> captures;
    std::array<bool, training::kActCount> seen{};
    std::uint64_t since = 0;
    auto act = training::Act::finish;
    std::size_t next = 0;
    haptics::TickOutput now;
    for (std::int64_t t_ns = 0; t_ns <= attempt.hand.samples.back().t_ns; t_ns += 1'000'000) {
        haptics::TickInput input;
        input.device = device.read(t_ns);
        for (; next < attempt.hand.commands.size() && attempt.hand.commands[next].t_ns <= t_ns; ++next)
            input.add(attempt.hand.commands[next].command);
        haptics::NeedleEvents events;
        simulation.step(input, now, events);
        session.update(input, now, events);
        const FrameState state = session.frameState(now);
        const training::Act asked = training::nextAct(state.progress, now, state.machines);
        if (asked != act) act = asked, since = now.tick;
        if (seen[std::size_t(act)] || now.tick < since + kSettled_ticks) continue;
        seen[std::size_t(act)] = true;
        captures.push_back({fmt::format("act-{:02}-step-{}", int(act), int(state.progress.step)), state});
    }
    return captures;
}

// Adds the notices of the syringe, and the refusals, each in the picture in which its step was asked for.
void addRefusals(std::vector<Capture>& captures) {
    const std::vector<Capture> acts = captures;
    const auto during = [&](training::Step step) {
        for (const Capture& one : acts)
            if (one.seen.progress.step == step) return one.seen;
        return acts.back().seen;
    };
    using training::Refusal, training::Step;
    const auto stepOf = [](Refusal refusal) {
        return refusal <= Refusal::lowerRibNotFelt    ? Step::findGap
               : refusal <= Refusal::ductTooShort     ? Step::findDuct
               : refusal <= Refusal::incisionTooLong  ? Step::incise
               : refusal <= Refusal::needleNotInGuide ? Step::guide
               : refusal <= Refusal::ductMissed       ? Step::advance
               : refusal <= Refusal::wireInNeedle     ? Step::aspirate
               : refusal <= Refusal::contrastAstray   ? Step::contrast
               : refusal <= Refusal::wirePierced      ? Step::wire
               : refusal <= Refusal::notDilated       ? Step::dilate
               : refusal <= Refusal::drainMisplaced   ? Step::drain
                                                      : Step::anaesthetise;
    };
    for (int r = 1; r < training::kRefusalCount; ++r) {
        FrameState state = during(stepOf(Refusal(r)));
        state.progress.refusal = Refusal(r), state.progress.refused_s = state.progress.elapsed_s;
        captures.push_back({fmt::format("refused-{:02}", r), state});
    }
    for (std::size_t d = 0; d < training::kDrawnNames.size(); ++d) {
        FrameState state = during(Step::aspirate);
        state.drawn = training::Drawn(d);
        captures.push_back({fmt::format("syringe-{}", training::kDrawnNames[d]), state});
    }
}

// Adds the expert beside the trainee's tool, in each step.
void addExpert(const Scene& scene, std::vector<Capture>& captures) {
    const Demonstration expert(scene.patient, scene.path, training::Course::drainage,
                               [&](const patient::Patient&) { return scene.touch; });
    const std::vector<Capture> acts = captures;
    for (int s = 0; s < training::kStepCount; ++s)
        for (const Capture& one : acts) {
            if (int(one.seen.progress.step) != s || !one.name.starts_with("act")) continue;
            FrameState state = one.seen;
            state.ghost_tool =
                expert.at(training::Step(s), 0.6 * expert.length_s(training::Step(s)), state.tick.breath);
            state.expert_note = expert.describeMissing(training::Step(s));
            if (state.ghost_tool) state.ghost_tool->length_m = state.needle.length_m;
            captures.push_back({fmt::format("expert-step-{}", s), state});
            break;
        }
}

PictureSettings settingsFor(const Scene& scene, const fs::path& folder, const char* device) {
    PictureSettings settings;
    settings.assets = test::assets();
    settings.config.folder = folder;
    settings.config.difficulties = test::difficulties();
    settings.config.difficulty = training::Difficulty::guided;
    settings.config.closed_look = true;
    settings.config.device = device;
    settings.config.fast = true;
    settings.press.touch = &scene.touch;
    settings.field = fieldOf(scene.path);
    return settings;
}

void drawHeadset(const Scene& scene, const std::vector<Capture>& captures, const fs::path& folder) {
    setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
    const fs::path script = folder / "head.json";
    std::ofstream(script) << fmt::format(
        R"({{"version": 2, "eyes": {{"recommended_size": [{0}, {0}],
                "left_fov_rad": [-0.55, 1.0, 0.95, -0.55], "right_fov_rad": [-0.55, 1.0, 0.95, -0.55]}},
            "head": [{{"t_s": 0, "position": [0.12, 1.45, 0.0],
                       "orientation": [-0.240, -0.118, -0.0295, 0.963]}}]}})",
        kEyePixels);
    PictureSettings settings = settingsFor(scene, folder, kControllers);
    settings.head_script = script;
    std::string why_not;
    const auto display = openPictures(scene.patient, scene.path, settings, why_not);
    if (!display) throw std::runtime_error(why_not);
    for (const Capture& one : captures)
        display->frame(one.seen, nullptr, one.name);
}

void drawWindow(const Scene& scene, const std::vector<Capture>& captures, const fs::path& folder) {
    const test::XDisplay screen(1500, 950);
    PictureSettings settings = settingsFor(scene, folder, kMouse);
    settings.window = std::make_shared<WindowPort>();
    settings.window->enableToolInput();
    std::string why_not;
    const auto display = openDesktop(scene.patient, scene.path, settings, why_not);
    if (!display) throw std::runtime_error(why_not);
    for (const Capture& one : captures) {
        // The window shows a state some frames after it was given.
        const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(4);
        while (std::chrono::steady_clock::now() < until)
            display->frame(one.seen, nullptr, "");
        const test::Screenshot shot = screen.shot();
        report::Canvas canvas(shot.width, shot.height, {});
        canvas.image(0, 0, shot.width, shot.height, shot.rgb);
        canvas.savePng(folder / (one.name + "_window.png"));
    }
}

void drawAll(const fs::path& folder, const std::string& where, const std::string& name) {
    fs::create_directories(folder);
    patient::Package package = drawnPatient();
    const patient::Patient planned(package);
    const patient::PlanResult plan = patient::planPaths(planned, {});
    const patient::PlannedPath path = pathForWire(patient::makeDuctSpace(planned), plan.paths);
    const Scene scene{.package = package, .path = path, .touch = haptics::makeTouchMap(planned)};
    std::vector<Capture> captures = actsOf(scene);
    addRefusals(captures);
    addExpert(scene, captures);
    std::erase_if(captures, [&](const Capture& one) { return one.name.find(name) == std::string::npos; });
    if (where != "window") drawHeadset(scene, captures, folder);
    if (where != "headset") drawWindow(scene, captures, folder);
    fmt::print("{} states drawn into {}\n", captures.size(), folder.string());
}

}  // namespace
}  // namespace stylet::trainer

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fputs("stylet-tutor-pictures FOLDER [headset|window] [NAME]\n", stderr);
        return 100;
    }
    try {
        stylet::trainer::drawAll(argv[1], argc > 2 ? argv[2] : "", argc > 3 ? argv[3] : "");
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-tutor-pictures: %s\n", e.what());
        return 1;
    }
    return 0;
}
