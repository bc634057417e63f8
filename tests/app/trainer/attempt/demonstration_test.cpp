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
    for (const Step step : {Step::wire, Step::drain, Step::done})  // steps of another course
        EXPECT_FALSE(at(step, 0.0));
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
    ExpertBeside beside_{[] { return make(); }};
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
    ExpertBeside beside([]() -> Demonstration { throw std::runtime_error("no scenario"); });
    beside.toggle(test::difficulties()[Difficulty::guided]);
    FrameState seen;
    for (int tries = 0; tries < 200; ++tries) {
        beside.addTo(seen, test::difficulties()[Difficulty::guided], 0.001);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_FALSE(seen.ghost_tool);
}

}  // namespace
}  // namespace stylet::trainer
