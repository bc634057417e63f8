// stylet-tutor-pictures FOLDER [headset|window] [NAME]: pictures of a guided drainage, to look at: each act
// that the expert does and its hint, each refusal, each notice, each alert, and the expert beside, in the
// headset (mock runtime) and in the window (Xvfb); and sheets of all of them. NAME: only pictures whose name
// contains it. Uses a synthetic patient.
#include <fmt/core.h>
#include <stb/stb_image.h>

#include <algorithm>
#include <array>
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
#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/session/contrast_feed.h"
#include "app/trainer/session/session.h"
#include "app/trainer/view/guide_panel.h"
#include "app/trainer/view/notice.h"
#include "app/trainer/view/pictures.h"
#include "app/training/tutor.h"
#include "haptics/devices/replay.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/support/x_display.h"

namespace stylet::trainer {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::uint64_t kSettled_ticks = 120;  // of an act, before its picture
// Of an eye. Its pixels are as fine as those of a headset, its view is narrower.
constexpr int kEyePixels = 1100;
constexpr double kHalfView_rad = 0.58;
constexpr Vec3 kEyes_m{0.05, 1.5, -0.05};
constexpr int kSheetColumns = 4, kSheetRows = 3, kSheetCaption_px = 22;

// A state with the contrast medium in it. `hint`: it is shown until the hint takes the prompt's place.
struct Shot {
    std::string name;
    FrameState seen;
    std::shared_ptr<const patient::ContrastTable> contrast;
    training::Act act = training::Act::finish;
    bool hint = false;
};
using Shots = std::vector<Shot>;

struct Scene {
    patient::Package package;
    patient::Patient patient{package};
    patient::PlannedPath path;
    haptics::TouchMap touch;
};

patient::Package drawnPatient() {
    patient::synth::SynthSettings settings;
    settings.spacing_m = 0.002;
    settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
    return patient::synth::makeReferencePatient(settings);
}

// The states of the expert's drainage at which each act is asked for.
Shots actsOf(const Scene& scene) {
    Scenario scenario = loadScenario(test::assets() / "scenarios" / "drainage.toml");
    scenario.patient_case = std::make_shared<const training::PatientCase>(
        training::loadCase(test::assets() / "cases" / "apixaban.toml"));
    const Attempt attempt = makeAttempt(scene.patient, scenario, scene.path, 1, 1000.0,
                                        [&](const patient::Patient&) { return scene.touch; });
    haptics::Simulation simulation(scene.patient, attempt.simulation, attempt.touchMap(),
                                   attempt.ductSpace());
    haptics::ReplayDevice device(attempt.hand, 0, attempt.simulation.profile);
    Session session(scene.patient, scene.path, {}, 0.0, nullptr);
    session.setCourse(training::Course::drainage);
    session.setCase(scenario.patient_case);
    session.setDifficulty(training::Difficulty::guided);
    Shots shots;
    ContrastFeed feed;
    auto contrast = std::make_shared<patient::ContrastTable>();
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
        const training::Act asked = training::nextAct(state.progress, now, state.equipment);
        if (asked != act) act = asked, since = now.tick;
        if (seen[std::size_t(act)] || now.tick < since + kSettled_ticks) continue;
        seen[std::size_t(act)] = true;
        feed.publish(session.contrast());
        auto painted = std::make_shared<patient::ContrastTable>(*contrast);
        if (feed.applyTo(*painted)) contrast = painted;
        shots.push_back({fmt::format("act-{:02}-step-{}", int(act), int(state.progress.step)), state,
                         session.contrast().begun() ? contrast : nullptr, act});
    }
    const std::uint32_t left = training::kAllSteps & ~session.log().progress.steps_done;
    for (int s = 0; s < training::kStepCount; ++s)
        if (training::contains(left, training::Step(s)))
            fmt::print(stderr, "the expert did not {}\n", training::stepName(training::Step(s)));
    return shots;
}

// Adds the acts that an expert is never asked for.
void addMistakes(Shots& shots) {
    using training::Act, training::Refusal, haptics::Tool;
    const auto add = [&](Act wanted, Act during, const auto& change) {
        if (std::ranges::find(shots, wanted, &Shot::act) != shots.end()) return;
        const auto found = std::ranges::find(shots, during, &Shot::act);
        if (found == shots.end()) return;
        Shot shot = *found;
        change(shot.seen);
        const FrameState& state = shot.seen;
        if (training::nextAct(state.progress, state.tick, state.equipment) != wanted)
            throw std::runtime_error(fmt::format("act {} is not asked for", int(wanted)));
        shot.act = wanted;
        shot.name = fmt::format("act-{:02}-step-{}", int(wanted), int(state.progress.step));
        shots.push_back(shot);
    };
    const auto missing = [](Refusal why) {
        return [why](FrameState& state) { state.progress.missing = why; };
    };
    const auto with = [](Tool tool) { return [tool](FrameState& state) { state.tick.tool = tool; }; };
    add(Act::liftOff, Act::pressGap, [](FrameState& state) { state.tick.tool_awaits_exit = true; });
    add(Act::selectFinger, Act::pressGap, with(Tool::scalpel));
    add(Act::shiftProbe, Act::holdProbeStill, missing(Refusal::ductBesidePlane));
    add(Act::turnProbe, Act::holdProbeStill, missing(Refusal::ductShadowed));
    add(Act::aimGuide, Act::parkProbe, missing(Refusal::ductBesideRail));
    add(Act::liftProbe, Act::parkProbe, [](FrameState& state) {
        state.progress.missing = Refusal::ductBesideRail;
        state.tick.probe_parked = true;
        state.tick.patient_from_probe = state.tick.patient_from_tool * haptics::kStylusFromProbe;
    });
    add(Act::pullNeedleBack, Act::pushToCapsule,
        [](FrameState& state) { state.progress.track_place = training::TrackPlace::beyond; });
    add(Act::snapNeedle, Act::selectGuide, with(Tool::guide));
    add(Act::enterSkin, Act::advance,
        [](FrameState& state) { state.tick.phase = haptics::Phase::outside, state.tick.tool = Tool::guide; });
    add(Act::withdrawToRetry, Act::advance, missing(Refusal::breathNotHeld));
    add(Act::seekDuct, Act::aspirate, [](FrameState& state) { state.tick.tissue = patient::Tissue::liver; });
    add(Act::pressPedal, Act::inject, [](FrameState& state) { state.equipment.xray.pedal = false; });
    add(Act::selectWire, Act::feedWire, with(Tool::needle));
    add(Act::withdrawDrain, Act::pushDilator, [](FrameState& state) {
        state.tick.tool = Tool::drain;
        state.tick.access.drain_m = 0.02;
    });
    add(Act::pullWireBack, Act::feedWire, [](FrameState& state) { state.tick.access.pierced = true; });
    add(Act::finish, Act::releasePedal, [](FrameState& state) { state.equipment.xray.pedal = false; });
}

// The act during which each refusal is told.
constexpr std::array<training::Act, training::kRefusalCount> kRefusedDuring = [] {
    using training::Act;
    return std::array{Act::finish,
                      Act::pressGap,
                      Act::pressUpperRib,
                      Act::pressLowerRib,
                      Act::placeProbe,
                      Act::placeProbe,
                      Act::placeProbe,
                      Act::placeProbe,
                      Act::holdProbeStill,
                      Act::parkProbe,
                      Act::cut,
                      Act::cut,
                      Act::cut,
                      Act::enterSkin,
                      Act::advance,
                      Act::advance,
                      Act::advance,
                      Act::advance,
                      Act::aspirate,
                      Act::aspirate,
                      Act::selectWire,
                      Act::inject,
                      Act::feedWire,
                      Act::feedWire,
                      Act::withdrawDilator,
                      Act::withdrawWire,
                      Act::withdrawWire,
                      Act::withdrawWire,
                      Act::feedWire,
                      Act::feedWire,
                      Act::enterWheal,
                      Act::withdrawNumbingNeedle,
                      Act::numbSkin,
                      Act::numbSkin,
                      Act::pushToCapsule,
                      Act::numbCapsule,
                      Act::numbCapsule,
                      Act::pushDrain};
}();

// Adds what can be told during the acts: hints, refusals, notices, alerts and pain.
void addTold(Shots& shots) {
    const Shots acts = shots;
    const auto during = [&](training::Act act) {
        const auto found = std::ranges::find(acts, act, &Shot::act);
        return found != acts.end() ? *found : acts.back();
    };
    const auto add = [&](const std::string& name, training::Act act, const auto& change) {
        Shot shot = during(act);
        shot.name = name;
        // The panel is drawn again only at another time.
        shot.seen.tick.tick += 1000 * (shots.size() % 2);
        change(shot.seen);
        shots.push_back(shot);
    };
    for (Shot shot : acts) {
        if (training::hint(shot.act, training::kMouseControls).empty()) continue;
        shot.name = "hint" + shot.name.substr(3), shot.hint = true;
        shots.push_back(shot);
    }
    using training::Act;
    for (int r = 1; r < training::kRefusalCount; ++r)
        add(fmt::format("refused-{:02}", r), kRefusedDuring[std::size_t(r)], [&](FrameState& state) {
            state.progress.refusal = training::Refusal(r);
            state.progress.refused_s = state.progress.elapsed_s;
        });
    for (std::size_t d = 0; d < training::kDrawnNames.size(); ++d)
        add(fmt::format("notice-syringe-{}", training::kDrawnNames[d]), Act::aspirate,
            [&](FrameState& state) { state.drawn = training::Drawn(d); });
    add("notice-paused", Act::cut, [](FrameState& state) { state.paused_by_instructor = true; });
    add("notice-untracked", Act::cut, [](FrameState& state) {
        state.ticks_paused = true, state.return_distance_m = haptics::kDeviceNotReady_m;
    });
    add("notice-return", Act::cut,
        [](FrameState& state) { state.ticks_paused = true, state.return_distance_m = 0.012; });
    add("notice-jumped", Act::advance,
        [](FrameState& state) { state.tick.awaited |= haptics::kFaultAwayFromNeedle; });
    add("notice-rest", Act::selectScalpel, [](FrameState& state) { state.rest_due = true; });
    add("notice-stall", Act::cut, [](FrameState& state) { state.picture_stall_s = 3.0; });
    for (const haptics::FaultText& fault : haptics::faultTexts())
        add(fmt::format("notice-fault-{}", fault.name), Act::advance, [&](FrameState& state) {
            state.tick.faults = std::uint32_t(fault.bit), state.tick.stage = haptics::ForceStage::off;
        });
    add("alert-struck", Act::advance, [](FrameState& state) { state.glow.struck = 1.0f; });
    add("alert-reached", Act::aspirate, [](FrameState& state) { state.glow.reached = 1.0f; });
    add("pain", Act::cut, [](FrameState& state) { state.progress.pain = 7.0; });
    add("lights-out", Act::pressPedal, [](FrameState& state) { state.lights_out = true; });
}

// Adds the expert beside the trainee's tool, in each step.
void addExpert(const Scene& scene, Shots& shots) {
    const Demonstration expert(scene.patient, scene.path, training::Course::drainage,
                               [&](const patient::Patient&) { return scene.touch; });
    const Shots acts = shots;
    for (int s = 0; s < training::kStepCount; ++s)
        for (Shot one : acts) {
            if (int(one.seen.progress.step) != s || !one.name.starts_with("act")) continue;
            FrameState& state = one.seen;
            state.ghost_tool =
                expert.at(training::Step(s), 0.6 * expert.length_s(training::Step(s)), state.tick.breath);
            state.expert_note = expert.describeMissing(training::Step(s));
            if (state.ghost_tool) state.ghost_tool->length_m = state.needle.length_m;
            one.name = fmt::format("expert-step-{}", s);
            shots.push_back(one);
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
    settings.rearm_act = "press Enter";
    return settings;
}

// The same state when the hint takes the prompt's place.
FrameState afterAWhile(FrameState state) {
    state.tick.tick += std::uint64_t(1000.0 * training::kHintAfter_s) + 1000;
    return state;
}

void drawHeadset(const Scene& scene, const Shots& shots, const fs::path& folder) {
    setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
    const fs::path script = folder / "head.json";
    // The entry and the guide panel are both in view.
    const OperativeField field = fieldOf(scene.path);
    const Vec3 entry_m = stageFromPatient(scene.patient, field) * field.entry_m;
    const PanelPlace panel =
        guidePlace(entry_m, kEyes_m, letterAngle_rad(0.5 * kEyePixels / std::tan(kHalfView_rad)));
    const Quat turn =
        stageFromEyes(kEyes_m, 0.45 * entry_m + 0.55 * panel.stage_from_panel.position_m).rotation;
    std::ofstream(script) << fmt::format(
        R"({{"version": 2, "eyes": {{"recommended_size": [{0}, {0}],
                "left_fov_rad": [-{1}, {1}, {1}, -{1}], "right_fov_rad": [-{1}, {1}, {1}, -{1}]}},
            "head": [{{"t_s": 0, "position": [{2}, {3}, {4}], "orientation": [{5}, {6}, {7}, {8}]}}]}})",
        kEyePixels, kHalfView_rad, kEyes_m.x, kEyes_m.y, kEyes_m.z, turn.x, turn.y, turn.z, turn.w);
    PictureSettings settings = settingsFor(scene, folder, kControllers);
    settings.head_script = script;
    std::string why_not;
    const auto display = openPictures(scene.patient, scene.path, settings, why_not);
    if (!display) throw std::runtime_error(why_not);
    for (const Shot& one : shots) {
        const auto show = [&](const FrameState& state, const std::string& name) {
            display->frame(state, one.contrast.get(), name);
        };
        if (one.hint) show(one.seen, "");
        show(one.hint ? afterAWhile(one.seen) : one.seen, one.name);
    }
}

void drawWindow(const Scene& scene, const Shots& shots, const fs::path& folder) {
    const test::XDisplay screen(1500, 950);
    PictureSettings settings = settingsFor(scene, folder, kMouse);
    settings.window = std::make_shared<WindowPort>();
    settings.window->enableToolInput();
    std::string why_not;
    const auto display = openDesktop(scene.patient, scene.path, settings, why_not);
    if (!display) throw std::runtime_error(why_not);
    for (const Shot& one : shots) {
        const auto draw = [&](const FrameState& state, std::chrono::milliseconds time) {
            const auto until = std::chrono::steady_clock::now() + time;
            while (std::chrono::steady_clock::now() < until)
                display->frame(state, one.contrast.get(), "");
            return screen.shot();
        };
        // The window shows a state some frames after it was given.
        if (one.hint) draw(one.seen, 500ms);
        const FrameState state = one.hint ? afterAWhile(one.seen) : one.seen;
        test::Screenshot shot = draw(state, 1s), before;
        for (int tries = 0; tries < 8 && shot.rgb != before.rgb; ++tries)
            before = std::exchange(shot, draw(state, 500ms));
        report::Canvas canvas(shot.width, shot.height, {});
        canvas.image(0, 0, shot.width, shot.height, shot.rgb);
        canvas.savePng(folder / (one.name + "_window.png"));
    }
}

// Sheets of the pictures, several on each.
void drawSheets(const Shots& shots, const fs::path& folder, const std::string& ending) {
    constexpr std::size_t kEach = kSheetColumns * kSheetRows;
    for (std::size_t first = 0; first < shots.size(); first += kEach) {
        std::unique_ptr<report::Canvas> sheet;
        for (std::size_t i = first; i < std::min(first + kEach, shots.size()); ++i) {
            int width = 0, height = 0, channels = 0;
            const std::string file = folder / (shots[i].name + ending);
            const std::unique_ptr<stbi_uc, void (*)(void*)> pixels(
                stbi_load(file.c_str(), &width, &height, &channels, 3), stbi_image_free);
            if (!pixels) throw std::runtime_error("no picture " + file);
            if (!sheet)
                sheet = std::make_unique<report::Canvas>(kSheetColumns * width / 2,
                                                         kSheetRows * (height / 2 + kSheetCaption_px),
                                                         report::Colour{});
            const double x = double((i - first) % kSheetColumns) * width / 2,
                         y = double((i - first) / kSheetColumns) * (height / 2 + kSheetCaption_px);
            sheet->image(x, y, width, height, {pixels.get(), pixels.get() + 3 * width * height}, 0.5);
            sheet->text({x + 6.0, y + height / 2 + 16.0}, shots[i].name,
                        {.size = 14.0, .colour = {1.0, 1.0, 1.0}});
        }
        sheet->savePng(folder / fmt::format("sheet-{:02}{}", first / kEach, ending));
    }
}

void drawAll(const fs::path& folder, const std::string& where, const std::string& name) {
    fs::create_directories(folder);
    patient::Package package = drawnPatient();
    const patient::Patient planned(package);
    const patient::PlanResult plan = patient::planPaths(planned, {});
    const patient::PlannedPath path = pathForWire(patient::makeDuctSpace(planned), plan.paths);
    const Scene scene{.package = package, .path = path, .touch = haptics::makeTouchMap(planned)};
    Shots shots = actsOf(scene);
    addMistakes(shots);
    addTold(shots);
    addExpert(scene, shots);
    std::erase_if(shots, [&](const Shot& one) { return one.name.find(name) == std::string::npos; });
    // An alert that an act begins would last into the hints, which are drawn at later ticks.
    for (const bool hints : {false, true}) {
        Shots some;
        std::ranges::copy_if(shots, std::back_inserter(some),
                             [&](const Shot& one) { return one.hint == hints; });
        if (some.empty()) continue;
        if (where != "window") drawHeadset(scene, some, folder);
        if (where != "headset") drawWindow(scene, some, folder);
    }
    if (where != "window") drawSheets(shots, folder, "_left.png");
    if (where != "headset") drawSheets(shots, folder, "_window.png");
    fmt::print("{} states drawn into {}\n", shots.size(), folder.string());
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
