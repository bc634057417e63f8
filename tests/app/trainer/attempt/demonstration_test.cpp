// The expert beside the trainee: each step is the scripted expert's, repeats itself, and stays on the
// breathing patient. Only a guided attempt shows it.
#include "app/trainer/attempt/demonstration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <thread>

#include "app/trainer/attempt/reference_path.h"
#include "patient/synth/synth.h"
#include "tests/app/trainer/difficulties.h"

namespace stylet::trainer {
namespace {

using haptics::Tool;
using training::Difficulty;
using training::Step;

class DemonstrationTest : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        patient::synth::SynthSettings settings;
        settings.spacing_m = 0.003;
        settings.defaults = patient::loadTissueDefaults(test::assets() / "tissue" / "ptcd.toml");
        package_ = new patient::Package(patient::synth::makeReferencePatient(settings));
        patient_ = new patient::Patient(*package_);
        path_ = new patient::PlannedPath(patient::planPaths(*patient_, {}).paths.front());
        shown_ = new Demonstration(make());
    }
    static void TearDownTestSuite() {
        delete shown_;
        delete path_;
        delete patient_;
        delete package_;
    }
    static Demonstration make() {
        return {*patient_, *path_, training::Course::puncture,
                [](const patient::Patient& p) { return haptics::makeTouchMap(p); }};
    }
    static std::optional<GhostTool> at(Step step, double t_s) { return shown_->at(step, t_s, {}); }

    static inline patient::Package* package_ = nullptr;
    static inline patient::Patient* patient_ = nullptr;
    static inline patient::PlannedPath* path_ = nullptr;
    static inline Demonstration* shown_ = nullptr;
};

TEST_F(DemonstrationTest, EveryStepOfThePunctureIsShownWithItsTools) {
    const auto shows = [&](Step step, Tool tool) {
        for (double t_s = 0.0; t_s < shown_->length_s(step); t_s += Demonstration::kSample_s)
            if (at(step, t_s)->tool == tool) return true;
        return false;
    };
    EXPECT_TRUE(shows(Step::findGap, Tool::finger));
    EXPECT_TRUE(shows(Step::findDuct, Tool::probe));
    EXPECT_TRUE(shows(Step::incise, Tool::scalpel));
    EXPECT_TRUE(shows(Step::guide, Tool::needle));
    EXPECT_TRUE(shows(Step::advance, Tool::needle));
    EXPECT_GT(shown_->length_s(Step::contrast), 0.0);
    for (const Step step :
         {Step::findGap, Step::findDuct, Step::incise, Step::guide, Step::advance, Step::contrast})
        EXPECT_EQ(shown_->describeMissing(step), "");
    for (const Step step : {Step::wire, Step::drain, Step::done})  // steps of another course
        EXPECT_FALSE(at(step, 0.0));
}

// On some paths the script does not succeed in a step.
TEST_F(DemonstrationTest, NoStepOfADrainageIsMissingWithoutAReason) {
    const patient::DuctSpace ducts = patient::makeDuctSpace(*patient_);
    const auto shows = [](const Demonstration& one, Step step) { return one.describeMissing(step).empty(); };
    std::optional<Demonstration> found;
    int tried = 0;
    for (const patient::PlannedPath& path : patient::planPaths(*patient_, {}).paths) {
        if (sureWireReach_m(ducts, path) < kSureReach_m) continue;
        found.emplace(*patient_, path, training::Course::drainage,
                      [](const patient::Patient& p) { return haptics::makeTouchMap(p); });
        const bool all =
            shows(*found, Step::wire) && shows(*found, Step::dilate) && shows(*found, Step::drain);
        if (all || ++tried == 10) break;
    }
    ASSERT_TRUE(found);
    const Demonstration& drainage = *found;
    for (int s = 0; s < training::kStepCount; ++s) {
        const Step step = Step(s);
        const std::string missing = drainage.describeMissing(step);
        if (missing.empty())
            EXPECT_TRUE(drainage.at(step, 0.0, {})) << stepName(step);
        else
            EXPECT_NE(missing.find(stepName(step)), std::string::npos) << missing;
    }
    EXPECT_NE(drainage.describeMissing(Step::done), "");
    // Wire, dilator and drain go forward on their track.
    for (const auto& [step, tool] :
         {std::pair{Step::wire, Tool::wire}, std::pair{Step::dilate, Tool::dilator},
          std::pair{Step::drain, Tool::drain}}) {
        ASSERT_EQ(drainage.describeMissing(step), "");
        double shallowest_m = 1.0, deepest_m = -1.0;
        for (double t_s = 0.0; t_s < drainage.length_s(step); t_s += Demonstration::kSample_s) {
            const auto ghost = drainage.at(step, t_s, {});
            ASSERT_EQ(ghost->access.has_value(), haptics::isAccessTool(ghost->tool));
            if (ghost->tool != tool) continue;
            const haptics::AccessOutput& access = *ghost->access;
            const double depth_m = tool == Tool::wire      ? access.wire_m
                                   : tool == Tool::dilator ? access.dilator_m
                                                           : access.drain_m;
            shallowest_m = std::min(shallowest_m, depth_m), deepest_m = std::max(deepest_m, depth_m);
        }
        EXPECT_GT(deepest_m - shallowest_m, 0.015) << stepName(step);
    }
}

// In each step the tool that does it reaches its place: the entry, or the duct.
TEST_F(DemonstrationTest, ToolsReachTheirPlaces) {
    const auto nearest_m = [&](Step step, Tool tool, const Vec3& place_m) {
        double nearest = 1.0;
        for (double t_s = 0.0; t_s < shown_->length_s(step); t_s += Demonstration::kSample_s)
            if (const auto ghost = at(step, t_s); ghost->tool == tool)
                nearest = std::min(nearest, glm::distance(ghost->patient_from_tool.position_m, place_m));
        return nearest;
    };
    EXPECT_LT(nearest_m(Step::findGap, Tool::finger, path_->entry_reference_m), 0.010);
    EXPECT_LT(nearest_m(Step::incise, Tool::scalpel, path_->entry_reference_m), 0.008);
    EXPECT_LT(nearest_m(Step::advance, Tool::needle, path_->target_reference_m), 0.010);
}

TEST_F(DemonstrationTest, AStepRepeatsItselfAfterARest) {
    const double length_s = shown_->length_s(Step::findGap), loop_s = length_s + Demonstration::kRest_s;
    const auto place = [&](double t_s) { return at(Step::findGap, t_s)->patient_from_tool.position_m; };
    for (const double t_s : {0.01, 1.01, length_s - 0.01})  // in the middle of a sample
        for (const int times : {1, 7})
            EXPECT_EQ(place(t_s), place(t_s + times * loop_s));
    EXPECT_EQ(place(length_s + 0.01), place(loop_s - 0.01)) << "at rest";
    EXPECT_NE(place(0.01), place(0.5 * length_s));
    EXPECT_EQ(place(-1.0), place(0.0));
}

// Deep breath: the expert's needle stays in the tissue that it is in.
TEST_F(DemonstrationTest, FollowsTheBreathOfThePatientThatIsShown) {
    const patient::MotionModel& motion = package_->motion;
    const patient::Surrogate deep{1.0, 0.0, 0.0};
    const double end_s = shown_->length_s(Step::advance) - 0.01;
    const Vec3 rest_m = shown_->at(Step::advance, end_s, {})->patient_from_tool.position_m;
    const Vec3 deep_m = shown_->at(Step::advance, end_s, deep)->patient_from_tool.position_m;
    EXPECT_GT(glm::distance(rest_m, deep_m), 0.002);
    EXPECT_LT(glm::distance(deep_m, patient::deformedFromReference(
                                        motion, deep, patient::referenceFromDeformed(motion, {}, rest_m))),
              1e-4);
}

class BesideTest : public DemonstrationTest {
  protected:
    FrameState seenAt(std::uint64_t tick, Step step = Step::findGap) {
        FrameState seen;
        seen.tick.tick = tick;
        seen.progress.step = step;
        return seen;
    }
    // Waits for the demonstration, which is computed on another thread.
    FrameState shownAt(std::uint64_t tick, Difficulty difficulty) {
        FrameState seen = seenAt(tick);
        for (int tries = 0; tries < 6000 && !seen.ghost_tool; ++tries) {
            beside_.addTo(seen, test::difficulties()[difficulty], 0.001);
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return seen;
    }
    std::vector<std::string> said_;
    ExpertBeside beside_{[] { return make(); }, [this](const std::string& text) { said_.push_back(text); }};
};

TEST_F(BesideTest, IsShownWhenWantedAndBeginsWithEachStep) {
    FrameState none = seenAt(1);
    beside_.addTo(none, test::difficulties()[Difficulty::guided], 0.001);
    EXPECT_FALSE(none.ghost_tool) << "the expert was not requested";
    EXPECT_NE(beside_.toggle(test::difficulties()[Difficulty::guided]).find("beside you"), std::string::npos);
    const FrameState begun = shownAt(1000, Difficulty::guided);
    ASSERT_TRUE(begun.ghost_tool);
    EXPECT_EQ(begun.ghost_tool->patient_from_tool.position_m,
              at(Step::findGap, 0.0)->patient_from_tool.position_m);
    FrameState later = seenAt(2500);
    beside_.addTo(later, test::difficulties()[Difficulty::guided], 0.001);
    EXPECT_EQ(later.ghost_tool->patient_from_tool.position_m,
              at(Step::findGap, 1.5)->patient_from_tool.position_m);
    FrameState next = seenAt(4000, Step::findDuct);
    beside_.addTo(next, test::difficulties()[Difficulty::guided], 0.001);
    EXPECT_EQ(next.ghost_tool->patient_from_tool.position_m,
              at(Step::findDuct, 0.0)->patient_from_tool.position_m);
    beside_.toggle(test::difficulties()[Difficulty::guided]);
    FrameState ended = seenAt(4100, Step::findDuct);
    beside_.addTo(ended, test::difficulties()[Difficulty::guided], 0.001);
    EXPECT_FALSE(ended.ghost_tool);
}

// The script of a puncture passes no wire.
TEST_F(BesideTest, SaysOnceWhatItCannotShowAndWhy) {
    const auto shown = [&](std::uint64_t tick, Step step) {
        FrameState seen = seenAt(tick, step);
        beside_.addTo(seen, test::difficulties()[Difficulty::guided], 0.001);
        return seen;
    };
    beside_.toggle(test::difficulties()[Difficulty::guided]);
    const FrameState begun = shownAt(1000, Difficulty::guided);
    ASSERT_TRUE(begun.ghost_tool);
    EXPECT_EQ(begun.expert_note, "");
    EXPECT_TRUE(said_.empty());
    const FrameState wire = shown(2000, Step::wire);
    EXPECT_FALSE(wire.ghost_tool);
    ASSERT_EQ(said_.size(), 1u);
    EXPECT_EQ(
        said_[0],
        "the expert cannot show \"pass the wire down the duct\": the script does not complete it on this "
        "path");
    EXPECT_EQ(wire.expert_note, said_[0]);
    EXPECT_EQ(shown(2000 + std::uint64_t(1e3 * ExpertBeside::kNoteShown_s), Step::wire).expert_note, "");
    EXPECT_EQ(said_.size(), 1u);
    const FrameState next = shown(20'000, Step::findDuct);
    EXPECT_TRUE(next.ghost_tool);
    EXPECT_EQ(next.expert_note, "");
    EXPECT_EQ(said_.size(), 1u);
    // Asked for again, it says it again; also when no step is left.
    for (int i = 0; i < 2; ++i)
        beside_.toggle(test::difficulties()[Difficulty::guided]);
    shown(21'000, Step::wire), shown(22'000, Step::done);
    ASSERT_EQ(said_.size(), 3u);
    EXPECT_NE(said_[2].find("all steps are done"), std::string::npos);
}

TEST_F(BesideTest, IsRefusedUnlessGuidedAndEndsWhenAnExamBegins) {
    for (const Difficulty difficulty : {Difficulty::practice, Difficulty::exam}) {
        EXPECT_NE(beside_.toggle(test::difficulties()[difficulty]).find("guided attempts only"),
                  std::string::npos);
        FrameState seen = seenAt(1);
        beside_.addTo(seen, test::difficulties()[difficulty], 0.001);
        EXPECT_FALSE(seen.ghost_tool);
    }
    beside_.toggle(test::difficulties()[Difficulty::guided]);
    ASSERT_TRUE(shownAt(1000, Difficulty::guided).ghost_tool);
    FrameState exam = seenAt(1100);
    beside_.addTo(exam, test::difficulties()[Difficulty::exam], 0.001);
    EXPECT_FALSE(exam.ghost_tool);
    FrameState guided = seenAt(1200);  // it must be asked for again
    beside_.addTo(guided, test::difficulties()[Difficulty::guided], 0.001);
    EXPECT_FALSE(guided.ghost_tool);
}

TEST(Beside, AFailureEndsItAndNotTheAttempt) {
    std::vector<std::string> said;
    ExpertBeside beside([]() -> Demonstration { throw std::runtime_error("no scenario"); },
                        [&](const std::string& text) { said.push_back(text); });
    beside.toggle(test::difficulties()[Difficulty::guided]);
    FrameState seen;
    for (int tries = 0; tries < 5000 && said.empty(); ++tries) {
        beside.addTo(seen, test::difficulties()[Difficulty::guided], 0.001);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_FALSE(seen.ghost_tool);
    EXPECT_EQ(said, std::vector<std::string>{"the expert cannot be shown: no scenario"});
}

}  // namespace
}  // namespace stylet::trainer
