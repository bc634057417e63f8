// Simulated users follow the wizard's instructions; some of them do not.
#include "xr/registration/wizard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/xr/registration/study.h"

namespace stylet::xr::registration {
namespace {

using study::Random;
using study::Truth;
using testing::HasSubstr;

constexpr double kTick_s = 0.01;

// Simulates both hands, at a hundred samples per second.
class User {
  public:
    explicit User(const WizardSettings& settings, double noise_m = 0.0003)
        : wizard(settings), noise_m_(noise_m) {
        truth = study::makeTruth({.gimbal_m = 0.002, .scale_error = 0.003}, random);
        if (settings.grip_from_tip_m) truth.grip_from_tip_m = *settings.grip_from_tip_m;
    }

    void tick(bool press = false, bool back = false) {
        now_s += kTick_s;
        const std::vector<TimedPose> device = {{now_s, device_at}};
        Pose grip{turn, truth.inStage(device_at) - turn * truth.grip_from_tip_m};
        grip.position_m += slip_m + noise_m_ * random.normal3();
        const std::vector<TimedPose> tracked = {{now_s, grip}};
        wizard.step({now_s, device_ready ? PoseStream(device) : PoseStream(),
                     seen ? PoseStream(tracked) : PoseStream(), press, back});
    }
    void press() { tick(true), tick(); }
    void wait(double seconds) {
        for (double t_s = 0.0; t_s < seconds; t_s += kTick_s)
            tick();
    }
    void turnAbout(double seconds, double max_rad = 0.6) {
        const double begin_s = now_s;
        while (now_s - begin_s < seconds && wizard.stage() == WizardStage::tip) {
            const double t_s = now_s - begin_s;
            turn = glm::angleAxis(max_rad * std::sin(2.1 * t_s), Vec3(1, 0, 0)) *
                   glm::angleAxis(max_rad * std::sin(3.3 * t_s), Vec3(0, 0, 1));
            tick();
        }
    }
    void findTip() {
        press();
        turnAbout(20.0);
    }
    void touch(const Vec3& place) {
        device_at = {random.turn(0.5), place};
        turn = random.turn(0.5);
        press();
        wait(0.6);
    }
    void touchAll(int points) {
        for (int i = 0; i < points && wizard.stage() == WizardStage::places; ++i)
            touch(*wizard.nextPlace_m());
    }
    // Moves the tips through the whole cube and rotates the controller.
    void sweep(double seconds) {
        const double begin_s = now_s;
        while (now_s - begin_s < seconds && wizard.stage() == WizardStage::sweep) {
            const double t_s = now_s - begin_s;
            device_at = {glm::angleAxis(0.5 * std::sin(0.9 * t_s), Vec3(0, 1, 0)),
                         0.04 * Vec3(std::sin(1.1 * t_s), std::sin(1.7 * t_s + 1.0), std::sin(2.3 * t_s))};
            turn = glm::angleAxis(0.5 * std::sin(1.3 * t_s), Vec3(1, 0, 0));
            tick();
        }
    }
    double worst_m() const {
        double worst = 0.0;
        for (const Vec3& place : chooseTouchPlaces(Cube{}, 8))
            worst = std::max(worst,
                             glm::distance(wizard.fit()->inStage({{}, place}), truth.inStage({{}, place})));
        return worst;
    }

    Random random{11};
    Wizard wizard;
    Truth truth;
    double now_s = 0.0;
    Pose device_at;
    Quat turn{1.0, 0.0, 0.0, 0.0};
    Vec3 slip_m{0.0};
    bool device_ready = true, seen = true;

  private:
    double noise_m_;
};

TEST(Wizard, LeadsThroughTipAndPointsToARegistration) {
    User user({});
    user.tick();
    EXPECT_EQ(user.wizard.stage(), WizardStage::start);
    EXPECT_THAT(user.wizard.text().next_action, HasSubstr("to begin"));
    user.press();
    ASSERT_EQ(user.wizard.stage(), WizardStage::tip);
    user.findTip();
    ASSERT_EQ(user.wizard.stage(), WizardStage::places) << user.wizard.text().note;
    EXPECT_THAT(user.wizard.text().note, HasSubstr("tip is"));
    EXPECT_EQ(user.wizard.text().title, "Point 1 of 8");
    EXPECT_THAT(user.wizard.text().what, HasSubstr("ringed place, far left, low"));
    double before = 0.0;
    for (int i = 0; i < 8; ++i) {
        EXPECT_EQ(user.wizard.touchedCount(), std::size_t(i));
        EXPECT_GT(user.wizard.text().progress, before);
        before = user.wizard.text().progress;
        user.touch(*user.wizard.nextPlace_m());
    }
    ASSERT_EQ(user.wizard.stage(), WizardStage::result);
    EXPECT_TRUE(user.wizard.verdict().accept) << user.wizard.verdict().why;
    EXPECT_EQ(user.wizard.text().title, "It fits");
    EXPECT_LT(user.worst_m(), 2.0 * user.wizard.fit()->tre.worst_m);
    user.press();
    EXPECT_EQ(user.wizard.stage(), WizardStage::accepted);
    EXPECT_EQ(user.wizard.text().progress, 1.0);
}

TEST(Wizard, SweepProgressFollowsTheCoveredSpace) {
    User user({.in_motion = true});
    user.tick();
    user.press();
    user.findTip();
    ASSERT_EQ(user.wizard.stage(), WizardStage::sweep);
    user.press();
    user.wait(5.0);
    EXPECT_LT(user.wizard.text().recording, 0.2) << "a hand that rests fills nothing";
    user.sweep(10.0);
    EXPECT_GT(user.wizard.text().recording, 0.4);
    user.sweep(50.0);
    ASSERT_EQ(user.wizard.stage(), WizardStage::result);
    EXPECT_TRUE(user.wizard.verdict().accept) << user.wizard.verdict().why;
    EXPECT_LT(user.worst_m(), 0.001);
}

TEST(Wizard, AKnownTipSkipsTheTipCalibration) {
    User user({.grip_from_tip_m = Vec3(0.0, 0.0, -0.1)});
    user.tick();
    user.press();
    ASSERT_EQ(user.wizard.stage(), WizardStage::places);
    user.touchAll(8);
    ASSERT_EQ(user.wizard.stage(), WizardStage::result);
    EXPECT_TRUE(user.wizard.verdict().accept) << user.wizard.verdict().why;
}

TEST(Wizard, ReportsMissingStreamsAndWaits) {
    User user({});
    user.device_ready = false;
    user.wait(0.5);
    EXPECT_THAT(user.wizard.text().note, HasSubstr("device is not ready"));
    EXPECT_TRUE(user.wizard.text().is_warning);
    user.press();
    EXPECT_EQ(user.wizard.stage(), WizardStage::start) << "nothing begins without it";
    user.device_ready = true, user.seen = false;
    user.wait(0.5);
    EXPECT_THAT(user.wizard.text().note, HasSubstr("does not see the controller"));
    user.seen = true;
    user.wait(0.1);
    EXPECT_EQ(user.wizard.text().note, "");
}

TEST(Wizard, MovingOrRepeatedPointsAreNotRecorded) {
    User user({.grip_from_tip_m = Vec3(0.0, 0.0, -0.1)});
    user.tick();
    user.press();
    user.tick(true);
    user.wait(0.2);
    EXPECT_THAT(user.wizard.text().next_action, HasSubstr("Hold still"));
    user.device_at.position_m.x += 0.02;
    user.wait(0.5);
    EXPECT_THAT(user.wizard.text().note, HasSubstr("moved by 1"));
    EXPECT_EQ(user.wizard.touchedCount(), 0u);
    user.touch({0.0, 0.0, 0.0});
    EXPECT_EQ(user.wizard.touchedCount(), 1u);
    user.touch({0.003, 0.0, 0.0});
    EXPECT_THAT(user.wizard.text().note, HasSubstr("touched before"));
    EXPECT_EQ(user.wizard.touchedCount(), 1u);
    user.seen = false;
    user.touch({0.03, 0.03, 0.0});
    EXPECT_THAT(user.wizard.text().note, HasSubstr("controller was not seen"));
    user.seen = true, user.device_ready = false;
    user.touch({0.03, 0.03, 0.0});
    EXPECT_THAT(user.wizard.text().note, HasSubstr("device was not ready"));
    user.device_ready = true;
    user.tick(false, true);
    EXPECT_EQ(user.wizard.touchedCount(), 0u) << "the last one is taken back";
}

// The tip slips while it is turned. The wizard warns, and the user succeeds in a second attempt.
// HZ-TEACH-06
TEST(Wizard, ASlippingTipIsDetected) {
    User user({});
    user.tick();
    user.press();
    user.press();
    const double begin_s = user.now_s;
    while (user.now_s - begin_s < 21.0) {
        user.slip_m = 0.02 * Vec3(std::sin(0.7 * user.now_s), std::cos(1.1 * user.now_s), 0.0);
        user.turn = glm::angleAxis(0.5 * std::sin(2.0 * user.now_s), Vec3(1, 0, 0)) *
                    glm::angleAxis(0.5 * std::sin(3.1 * user.now_s), Vec3(0, 0, 1));
        user.tick();
    }
    EXPECT_EQ(user.wizard.stage(), WizardStage::tip);
    EXPECT_TRUE(user.wizard.text().is_warning) << user.wizard.text().note;
    user.slip_m = Vec3(0.0);
    user.findTip();
    EXPECT_EQ(user.wizard.stage(), WizardStage::places) << user.wizard.text().note;
}

// HZ-TEACH-06
TEST(Wizard, ABadResultRestartsTheRegistration) {
    User user({});
    user.tick();
    user.press();
    user.findTip();
    for (int i = 0; i < 8; ++i) {
        user.slip_m = 0.03 * user.random.direction();  // the tips never touch
        user.touch(*user.wizard.nextPlace_m());
    }
    ASSERT_EQ(user.wizard.stage(), WizardStage::result);
    EXPECT_FALSE(user.wizard.verdict().accept);
    EXPECT_EQ(user.wizard.text().title, "Once more, please");
    EXPECT_FALSE(user.wizard.verdict().why.empty());
    user.slip_m = Vec3(0.0);
    user.press();
    EXPECT_EQ(user.wizard.stage(), WizardStage::start);
    EXPECT_EQ(user.wizard.touchedCount(), 0u);
    user.press();
    user.findTip();
    user.touchAll(8);
    EXPECT_TRUE(user.wizard.verdict().accept) << user.wizard.verdict().why;
    user.tick(false, true);
    EXPECT_EQ(user.wizard.stage(), WizardStage::start) << "menu does it again even so";
}

// One touch shows whether an earlier registration is still valid. If it is not, the full procedure follows.
TEST(Wizard, VerifiesAnEarlierRegistration) {
    for (const bool moved : {false, true}) {
        WizardSettings settings;
        User first(settings);
        const Truth& truth = first.truth;
        settings.earlier = StoredRegistration{truth.stage_from_device, truth.scale, truth.stylus_from_tip_m,
                                              truth.grip_from_tip_m,   0.001,       0.001};
        User user(settings);
        if (moved) user.truth.stage_from_device.position_m.x += 0.03;
        user.tick();
        EXPECT_THAT(user.wizard.text().title, HasSubstr("where it was"));
        user.press();
        ASSERT_EQ(user.wizard.stage(), WizardStage::places) << "the tip is known";
        EXPECT_EQ(user.wizard.text().title, "Point 1 of 1");
        user.touch(*user.wizard.nextPlace_m());
        ASSERT_EQ(user.wizard.stage(), WizardStage::result);
        EXPECT_TRUE(user.wizard.verifiesEarlier());
        EXPECT_EQ(user.wizard.verdict().accept, !moved) << user.wizard.verdict().why;
        EXPECT_EQ(user.wizard.text().title, moved ? "It has moved" : "It holds");
        EXPECT_LE(user.wizard.text().next_action.size(), 50u) << "one line of the card";
        user.press();
        EXPECT_EQ(user.wizard.stage(), moved ? WizardStage::start : WizardStage::accepted);
        EXPECT_EQ(user.wizard.verifiesEarlier(), !moved);
        if (!moved) continue;
        user.press();
        user.findTip();
        user.touchAll(8);
        ASSERT_EQ(user.wizard.stage(), WizardStage::result);
        EXPECT_TRUE(user.wizard.verdict().accept) << user.wizard.verdict().why;
        EXPECT_LT(user.worst_m(), 2.0 * user.wizard.fit()->tre.worst_m);
    }
}

TEST(Wizard, TheSketchShowsDoneAndRemainingPlaces) {
    User user({.grip_from_tip_m = Vec3(0.0, 0.0, -0.1)});
    user.tick();
    EXPECT_FALSE(user.wizard.sketch().shown);
    EXPECT_EQ(user.wizard.gripFromTip_m(), user.truth.grip_from_tip_m);
    user.press();
    const WizardSketch before = user.wizard.sketch();
    EXPECT_TRUE(before.shown);
    EXPECT_EQ(before.to_do.size(), 8u);
    EXPECT_EQ(before.next, before.to_do.front());
    user.touch(*before.next);
    const WizardSketch after = user.wizard.sketch();
    EXPECT_EQ(after.to_do.size(), 7u);
    ASSERT_EQ(after.done.size(), 1u);
    EXPECT_LT(glm::distance(after.done[0], *before.next), 1e-9);
    EXPECT_EQ(after.tip, before.next);
}

// Every state has its own text, with lines that fit the panel.
TEST(Wizard, EveryStageHasText) {
    std::set<std::string> titles;
    const auto look = [&](const Wizard& wizard) {
        const WizardText text = wizard.text();
        titles.insert(text.title);
        EXPECT_FALSE(text.title.empty());
        EXPECT_FALSE(text.what.empty());
        EXPECT_LT(text.what.size() + text.note.size(), 320u);
        EXPECT_LE(text.next_action.size(), 50u) << "one line of the card";
        EXPECT_GE(text.progress, 0.0);
        EXPECT_LE(text.progress, 1.0);
    };
    for (const bool in_motion : {false, true}) {
        User user({.in_motion = in_motion});
        user.tick(), look(user.wizard);
        user.press(), look(user.wizard);
        user.findTip(), look(user.wizard);
        user.press(), user.sweep(60.0);
        user.touchAll(8), look(user.wizard);
        user.press(), look(user.wizard);
    }
    EXPECT_EQ(titles.size(), 7u) << testing::PrintToString(titles);
}

}  // namespace
}  // namespace stylet::xr::registration
