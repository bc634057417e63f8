#include "app/trainer/view/guide_panel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/view/notice.h"
#include "tests/app/trainer/difficulties.h"

namespace stylet::trainer {
namespace {

using training::Difficulty;

FrameState feltAt(double t_s, double force_n = 0.5) {
    FrameState seen;
    seen.tick.tick = std::uint64_t(t_s * 1000.0 + 0.5);
    seen.tick.force_n = force_n;
    return seen;
}

TEST(GuidePanel, RedrawsTenTimesASecondWhileVisible) {
    GuidePanel panel(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
    for (double t_s = 0.0; t_s < 2.0; t_s += 0.011)
        panel.update(feltAt(t_s), true);
    EXPECT_LE(panel.revision(), 20u);
    EXPECT_GE(panel.revision(), 17u);
    const std::uint64_t before = panel.revision();
    for (double t_s = 2.0; t_s < 4.0; t_s += 0.011)
        panel.update(feltAt(t_s), false);
    EXPECT_EQ(panel.revision(), before) << "nobody looked";
}

TEST(GuidePanel, RecordsForceWhileHidden) {
    GuidePanel felt(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001),
        flat(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
    for (double t_s = 0.0; t_s < 5.0; t_s += 0.05) {
        felt.update(feltAt(t_s, 1.0 + std::sin(t_s)), false);
        flat.update(feltAt(t_s), false);
    }
    felt.update(feltAt(5.1), true), flat.update(feltAt(5.1), true);
    EXPECT_NE(felt.rgba(), flat.rgba());
}

// When a replay goes back, the panel shows the readings of that time, and the curve ends there.
TEST(GuidePanel, GoesBackWithAReplay) {
    GuidePanel there(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001),
        back(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
    for (double t_s = 0.0; t_s < 8.0; t_s += 0.05) {
        back.update(feltAt(t_s, 1.0 + std::sin(t_s)), true);
        if (t_s < 4.01) there.update(feltAt(t_s, 1.0 + std::sin(t_s)), false);
    }
    const std::vector<std::uint8_t> end = back.rgba();
    there.update(feltAt(4.0, 2.0), true), back.update(feltAt(4.0, 2.0), true);
    EXPECT_EQ(back.rgba(), there.rgba());
    back.update(feltAt(8.0, 2.0), true);
    EXPECT_NE(back.rgba(), there.rgba());
}

// HZ-TEACH-12
TEST(GuidePanel, HintsAppearOnlyAtGuidedDifficulty) {
    GuidePanel guided(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001),
        practice(test::difficulties()[Difficulty::practice], training::kMouseControls, 0.001);
    guided.update(feltAt(0.1), true), practice.update(feltAt(0.1), true);
    EXPECT_NE(guided.rgba(), practice.rgba());
}

// The trainee is told how much to inject at each end of the track, so the panel shows how much is there.
TEST(GuidePanel, ShowsTheInjectedAnaestheticWhileTheTrackIsNumbed) {
    const auto after = [](training::Step step, double injected_m3) {
        GuidePanel panel(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
        FrameState seen = feltAt(0.1);
        seen.progress.course = training::Course::drainage, seen.progress.step = step;
        seen.progress.depot_m3 = injected_m3, seen.progress.depot_wanted_m3 = 2e-6;
        panel.update(seen, true);
        return panel.rgba();
    };
    using training::Step;
    EXPECT_NE(after(Step::anaesthetise, 0.5e-6), after(Step::anaesthetise, 2.0e-6));
    EXPECT_EQ(after(Step::incise, 0.5e-6), after(Step::incise, 2.0e-6));
}

// Wire, dilator and drain show how deep their own tip is, although the needle is out.
TEST(GuidePanel, ShowsTheDepthOfWhatIsOnTheTrack) {
    const auto with = [](haptics::Tool tool, double depth_m) {
        GuidePanel panel(test::difficulties()[Difficulty::practice], training::kMouseControls, 0.001);
        FrameState seen = feltAt(0.1);
        seen.tick.tool = tool;
        seen.tick.access.open = seen.tick.access.wire_in = true;
        seen.tick.access.base_m = {0.080, 0.0, 0.0};
        (tool == haptics::Tool::dilator ? seen.tick.access.dilator_m
         : tool == haptics::Tool::drain ? seen.tick.access.drain_m
                                        : seen.tick.access.in_duct_m) = depth_m;
        panel.update(seen, true);
        return panel.rgba();
    };
    for (const haptics::Tool tool : {haptics::Tool::wire, haptics::Tool::dilator, haptics::Tool::drain})
        EXPECT_NE(with(tool, 0.010), with(tool, 0.060)) << haptics::kToolNames[std::size_t(tool)];
}

// Pixels of the prompt's two lines.
std::vector<std::uint8_t> promptAfter(double waited_s) {
    GuidePanel panel(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
    for (double t_s = 0.0; t_s <= waited_s; t_s += 0.5) {
        FrameState seen = feltAt(t_s);
        seen.tick.tool = haptics::Tool::finger;
        panel.update(seen, true);
    }
    const auto row = std::ptrdiff_t(4 * GuidePanel::kWidth);
    return {panel.rgba().begin() + 60 * row, panel.rgba().begin() + 130 * row};
}

TEST(GuidePanel, AHintTakesTurnsWithAPromptThatDoesNotHelp) {
    const std::vector<std::uint8_t> prompt = promptAfter(1.0);
    EXPECT_EQ(promptAfter(training::kHintAfter_s - 1.0), prompt);
    EXPECT_NE(promptAfter(training::kHintAfter_s + 1.0), prompt);
    EXPECT_EQ(promptAfter(training::kHintAfter_s + 7.0), prompt) << "the prompt comes back";
}

// Prompts, hints and refusals of every input fit into the panel's two lines.
TEST(GuidePanel, WordsFitIntoTwoLines) {
    report::Canvas canvas(GuidePanel::kWidth, GuidePanel::kHeight, {});
    const auto lines = [&](const std::string& text) {
        return wrapped(canvas, text, {.size = GuidePanel::kPrompt_px, .colour = {1.0, 1.0, 1.0}},
                       GuidePanel::kPromptWidth_px)
            .size();
    };
    for (const training::Controls* controls :
         {&training::kMouseControls, &training::kControllerControls, &training::kTypedControls,
          &training::kForceControls, &training::kFalconControls})
        for (int a = 0; a < training::kActCount; ++a)
            for (const std::string& text :
                 {prompt(training::Act(a), *controls), hint(training::Act(a), *controls)})
                EXPECT_LE(lines(text), 2u) << text;
    for (int r = 1; r < training::kRefusalCount; ++r) {
        const std::string why(refusalText(training::Refusal(r)));
        EXPECT_FALSE(why.empty()) << r;
        EXPECT_LE(lines("Not done: " + why + "."), 2u) << why;
    }
    for (const auto& entry : std::filesystem::directory_iterator(test::assets() / "cases")) {
        if (entry.path().extension() != ".toml") continue;
        const training::PatientCase c = training::loadCase(entry.path());
        for (int q = 0; q < training::kQuestionCount; ++q)
            EXPECT_LE(lines("Wrong: " + describeReason(c, training::Question(q)) + "."), 2u)
                << describeReason(c, training::Question(q));
    }
}

// A device whose travel is shorter than wire and tools must grip them anew. The prompts name a button
// for it.
TEST(GuidePanel, PromptsOfAForceDeviceNameTheButtonThatRegrips) {
    using training::Act;
    const auto names = [](const std::string& device, Act act, const char* button) {
        return prompt(act, controlsOf(device)).find(button) != std::string::npos;
    };
    for (const Act act : {Act::withdrawWire, Act::clearDrain, Act::withdrawNeedle, Act::withdrawDilator,
                          Act::withdrawDrain}) {
        EXPECT_TRUE(names("bridge", act, "button 1"));
        EXPECT_TRUE(names("falcon", act, "button 3"));
        for (const std::string& other :
             std::vector<std::string>{kMouse, kControllers, "spacemouse", "scripted"})
            EXPECT_FALSE(names(other, act, "button")) << other << " needs none";
    }
    EXPECT_EQ(haptics::ClutchSettings{}.button, 1u << 2) << "the Falcon's third";
}

// The panel says whether the newest answer was right, for a while.
TEST(GuidePanel, TellsWhetherAnAnswerWasRight) {
    const auto panelWith = [](std::uint32_t yes, double answered_s) {
        GuidePanel panel(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
        FrameState seen = feltAt(30.0);
        seen.patient_case = std::make_shared<const training::PatientCase>(
            training::loadCase(test::assets() / "cases" / "raised-inr.toml"));
        seen.progress.course = training::Course::drainage;
        seen.progress.has_case = true;
        seen.progress.step = training::Step::reviewCase;
        seen.progress.elapsed_s = 30.0;
        seen.progress.answered = 1, seen.progress.yes = yes, seen.progress.answered_s = answered_s;
        panel.update(seen, true);
        return panel.rgba();
    };
    EXPECT_NE(panelWith(0, 29.0), panelWith(1, 29.0));
    EXPECT_NE(panelWith(0, 29.0), panelWith(0, 10.0));
    EXPECT_EQ(panelWith(0, 10.0), panelWith(1, 10.0));
}

FrameState inserted(std::vector<Passed> passed) {
    FrameState seen = feltAt(1.0);
    seen.tick.tool = haptics::Tool::needle;
    seen.tick.phase = haptics::Phase::pass, seen.tick.depth_m = 0.05;
    seen.insertion.passed = std::move(passed);
    seen.insertion.felt = {{0.0f, 1.0f}, {0.05f, 0.5f}};
    return seen;
}

// A change of name, depth or risk changes the picture.
TEST(GuidePanel, ShowsWhichTissuesWerePassedHowDeep) {
    using patient::Role, patient::Tissue;
    const Passed skin{0.0, Tissue::skin, Role::pass, "skin", 1.0};
    const std::vector<std::vector<Passed>> ways{
        {},
        {skin},
        {skin, {0.03, Tissue::vessel, Role::pass, "portal vein", 0.4}},
        {skin, {0.04, Tissue::vessel, Role::pass, "portal vein", 0.4}},
        {skin, {0.03, Tissue::vessel, Role::pass, "hepatic vein", 0.4}},
        {skin, {0.03, Tissue::vessel, Role::risk, "portal vein", 0.4}}};
    std::vector<std::vector<std::uint8_t>> pictures;
    for (const auto& [width, height] :
         {std::pair{GuidePanel::kWidth, GuidePanel::kHeight}, {360, 220}, {300, 600}}) {
        pictures.clear();
        for (const std::vector<Passed>& way : ways) {
            const auto [fits_x, fits_y] = GuidePanel::sizeIn(width, height);
            GuidePanel panel(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
            panel.resize(fits_x, fits_y);
            panel.update(inserted(way), true);
            pictures.push_back(panel.rgba());
        }
        for (std::size_t i = 0; i < pictures.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                EXPECT_NE(pictures[i], pictures[j])
                    << i << " and " << j << " at " << width << " x " << height;
    }
}

// A name has no space to the right of its pole and ends there instead, but not over the force scale.
TEST(GuidePanel, NamesLeaveTheForceScaleFree) {
    using patient::Role, patient::Tissue;
    const auto scaleOf = [](const std::vector<Passed>& way) {
        GuidePanel panel(test::difficulties()[Difficulty::guided], training::kMouseControls, 0.001);
        FrameState seen = inserted(way);
        seen.insertion.felt.back() = {0.089f, 0.5f};
        panel.update(seen, true);
        std::vector<std::uint8_t> left;
        for (int y = 345; y < 620; ++y) {
            const auto row = panel.rgba().begin() + std::ptrdiff_t(4 * y * GuidePanel::kWidth);
            left.insert(left.end(), row, row + std::ptrdiff_t(4 * 85));
        }
        return left;
    };
    const Passed skin{0.0, Tissue::skin, Role::pass, "skin", 1.0};
    EXPECT_EQ(scaleOf({skin,
                       {0.002, Tissue::soft, Role::pass, "fat of the body wall", 1.0},
                       {0.013, Tissue::soft, Role::pass, "muscle", 1.0},
                       {0.029, Tissue::soft, Role::pass, "diaphragm", 1.0},
                       {0.034, Tissue::liver, Role::pass, "liver", 1.0},
                       {0.084, Tissue::duct, Role::pass, "bile ducts", 1.0}}),
              scaleOf({skin}));
}

TEST(GuidePanel, ResizeKeepsTheForceCurve) {
    for (const auto& [width, height] : {std::pair{1400, 700}, {360, 220}, {200, 900}, {1, 1}}) {
        const auto [fits_x, fits_y] = GuidePanel::sizeIn(width, height);
        EXPECT_LE(fits_x, width);
        EXPECT_LE(fits_y, height);
        EXPECT_GT(std::min(fits_x, fits_y), 0);
        EXPECT_TRUE(fits_x > 0.97 * width - 1.0 || fits_y > 0.97 * height - 1.0) << width << " x " << height;
    }
    GuidePanel kept(test::difficulties()[Difficulty::practice], training::kMouseControls, 0.001),
        lost(test::difficulties()[Difficulty::practice], training::kMouseControls, 0.001);
    for (double t_s = 0.0; t_s < 3.0; t_s += 0.05)
        kept.update(feltAt(t_s, 1.0 + std::sin(t_s)), false);
    kept.resize(500, 480), lost.resize(500, 480);
    kept.update(feltAt(3.0), true), lost.update(feltAt(3.0), true);
    EXPECT_EQ(kept.rgba().size(), std::size_t(4 * 500 * 480));
    EXPECT_NE(kept.rgba(), lost.rgba());
}

constexpr Vec3 kEntry{0.0, 1.05, -0.45}, kEyes{0.05, 1.5, -0.1};

TEST(GuidePlace, LettersAreLargeEnough) {
    for (const double px_per_rad : {900.0, 1200.0, 2000.0}) {
        const double letter_rad = letterAngle_rad(px_per_rad);
        const PanelPlace place = guidePlace(kEntry, kEyes, letter_rad);
        const double em_m = place.width_m * GuidePanel::kLetter_px / GuidePanel::kWidth;
        const double seen_rad = std::atan(em_m / glm::length(place.stage_from_panel.position_m - kEyes));
        EXPECT_GE(seen_rad, 0.98 * kMinText_rad);
        EXPECT_GE(seen_rad * px_per_rad, 0.98 * kMinText_px);
    }
}

TEST(GuidePlace, StaysInTheRoomAtLowResolution) {
    for (const double px_per_rad : {100.0, 256.0, 320.0}) {
        const PanelPlace place = guidePlace(kEntry, kEyes, letterAngle_rad(px_per_rad));
        EXPECT_LE(place.width_m, 1.2);
        EXPECT_TRUE(inView(place, stageFromEyes(kEyes, kEntry)));
    }
}

TEST(GuidePlace, NeverCoversThePuncture) {
    const PanelPlace place = guidePlace(kEntry, kEyes, kMinText_rad);
    for (double x = -0.5; x <= 0.5; x += 0.1)
        for (double y = 1.2; y <= 1.9; y += 0.1)
            for (double z = -0.4; z <= 0.5; z += 0.1)
                EXPECT_FALSE(covers(place, {x, y, z}, kEntry)) << "who stands at his side of the table";
    // Points behind the panel are covered.
    const Vec3 middle = place.stage_from_panel.position_m;
    EXPECT_TRUE(covers(place, middle + 0.5 * (middle - kEntry), kEntry));
}

TEST(GuidePlace, IsVisibleFromTheFrontOnly) {
    const PanelPlace place = guidePlace(kEntry, kEyes, kMinText_rad);
    const Vec3 middle = place.stage_from_panel.position_m;
    EXPECT_TRUE(inView(place, stageFromEyes(kEyes, middle)));
    EXPECT_FALSE(inView(place, stageFromEyes(kEyes, kEyes + (kEyes - middle)))) << "turned away";
    EXPECT_FALSE(inView(place, stageFromEyes(middle + (middle - kEyes), middle))) << "from behind";
}

}  // namespace
}  // namespace stylet::trainer
