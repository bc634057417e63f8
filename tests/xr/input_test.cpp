// Tests input with controllers of every vendor, tracked hands, and grip poses at any time.
#include <atomic>
#include <thread>

#include <time.h>

#include "render_loop.h"

namespace stylet::xr {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class InputTest : public SessionTest {};

struct Held {
    const char* profile;
    const char* menu_left;
    const char* menu_right;
    const char* squeeze;  // "" for none
    const char* stick;    // "" for none
    const char* select = "trigger/value";
};

constexpr Held kHeld[] = {
    {"khr/simple_controller", "menu/click", "menu/click", "", "", "select/click"},
    {"oculus/touch_controller", "menu/click", "b/click", "squeeze/value", "thumbstick"},
    {"valve/index_controller", "b/click", "b/click", "squeeze/value", "thumbstick"},
    {"htc/vive_controller", "menu/click", "menu/click", "squeeze/click", "trackpad"},
    {"microsoft/motion_controller", "menu/click", "menu/click", "squeeze/click", "thumbstick"},
    {"hp/mixed_reality_controller", "menu/click", "menu/click", "squeeze/value", "thumbstick"},
    {"htc/vive_focus3_controller", "menu/click", "b/click", "squeeze/click", "thumbstick"},
    {"bytedance/pico4_controller", "menu/click", "b/click", "squeeze/value", "thumbstick"},
    {"bytedance/pico_neo3_controller", "menu/click", "b/click", "squeeze/value", "thumbstick"},
    {"facebook/touch_controller_pro", "menu/click", "b/click", "squeeze/value", "thumbstick"},
    {"meta/touch_controller_plus", "menu/click", "b/click", "squeeze/value", "thumbstick"},
};

std::string valuesOf(const Held& held, const char* menu) {
    const auto on = [](const std::string& name) {
        return "\"" + name + "\": " + (name.ends_with("click") ? "true" : "0.75");
    };
    std::string values = R"([{"t_s": 1.2, )" + on(held.select) + ", " + on(menu);
    if (*held.squeeze) values += ", " + on(held.squeeze);
    if (*held.stick)
        values += std::string(", \"") + held.stick + R"(/x": 0.5, ")" + held.stick + R"(/y": -0.25)";
    return values + "}]";
}

TEST_F(InputTest, EveryControllersButtonsAreRead) {
    for (const Held& held : kHeld) {
        SCOPED_TRACE(held.profile);
        const std::string profile = std::string("/interaction_profiles/") + held.profile;
        useScenario(R"("controllers": {"profile": ")" + profile + R"(",
            "left": {"values": )" +
                    valuesOf(held, held.menu_left) + R"(},
            "right": {"poses": [{"t_s": 0, "position": [0.25, 1.25, -0.5]}],
                      "grip_from_aim": {"position": [0, 0.02, -0.05]},
                      "values": )" +
                    valuesOf(held, held.menu_right) + "}}");
        RenderLoop loop;
        EXPECT_THAT(loop.session.notes(), IsEmpty());
        ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
        loop.run(2);
        EXPECT_EQ(loop.session.facts().profiles[1], profile);
        EXPECT_FALSE(loop.session.hand(1).select);
        EXPECT_FALSE(loop.session.hand(0).menu);
        loop.run(30);
        for (const int side : {0, 1}) {
            const Hand hand = loop.session.hand(side);
            EXPECT_TRUE(hand.active);
            EXPECT_FALSE(hand.bare);
            EXPECT_TRUE(hand.select);
            EXPECT_TRUE(hand.menu);
            const bool pressed = std::string(held.squeeze).ends_with("click");
            EXPECT_FLOAT_EQ(hand.squeeze, *held.squeeze ? (pressed ? 1.0f : 0.75f) : 0.0f);
            EXPECT_FLOAT_EQ(hand.thumbstick[0], *held.stick ? 0.5f : 0.0f);
            EXPECT_FLOAT_EQ(hand.thumbstick[1], *held.stick ? -0.25f : 0.0f);
        }
        const Hand right = loop.session.hand(1);
        ASSERT_TRUE(right.stage_from_grip && right.stage_from_aim);
        EXPECT_NEAR(right.stage_from_grip->position_m.z, -0.5, 1e-6);
        EXPECT_NEAR(right.stage_from_aim->position_m.y, 1.27, 1e-6);
        EXPECT_NEAR(right.stage_from_aim->position_m.z, -0.55, 1e-6);
        loop.session.pulse(1, 0.5f, 20'000'000);
        loop.frame();
    }
    int pulses = 0;
    for (const auto& frame : frames())
        pulses += int(frame["haptic_pulses"].size());
    EXPECT_EQ(pulses, int(std::size(kHeld)));
}

TEST_F(InputTest, ExtensionProfilesAreSuggestedOnlyIfGranted) {
    setVariable("XRMOCK_WITHHOLD",
                "XR_BD_controller_interaction XR_FB_touch_controller_pro XR_META_touch_controller_plus "
                "XR_EXT_hp_mixed_reality_controller XR_HTC_vive_focus3_controller_interaction");
    {
        RenderLoop loop;
        EXPECT_THAT(loop.session.notes(), IsEmpty());
        EXPECT_THAT(loop.session.facts().extensions, testing::Not(Contains("XR_BD_controller_interaction")));
    }
    EXPECT_EQ(calls("xrSuggestInteractionProfileBindings").size(), 5u);
}

TEST_F(InputTest, AnUnknownButtonDoesNotDisableTheController) {
    // The runtime refuses two suggestions. The first has all bindings of the simple controller. The fourth
    // adds its second optional binding, vibration.
    useScenario(R"("events": [
        {"t_s": 0, "refuse": {"call": "xrSuggestInteractionProfileBindings", "nth": 1, "result": "XR_ERROR_PATH_UNSUPPORTED"}},
        {"t_s": 0, "refuse": {"call": "xrSuggestInteractionProfileBindings", "nth": 4, "result": "XR_ERROR_PATH_UNSUPPORTED"}}],
        "controllers": {"left": {"values": [{"t_s": 0, "menu/click": true, "select/click": true}]}})");
    RenderLoop loop;
    ASSERT_EQ(loop.session.notes().size(), 1u);
    EXPECT_THAT(loop.session.notes()[0],
                HasSubstr("simple_controller goes without /user/hand/left/output/haptic"));
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.run(3);
    EXPECT_EQ(loop.session.facts().profiles[0], "/interaction_profiles/khr/simple_controller");
    EXPECT_TRUE(loop.session.hand(0).select);
    EXPECT_TRUE(loop.session.hand(0).menu);
    EXPECT_TRUE(loop.session.hand(0).stage_from_aim.has_value());
}

TEST_F(InputTest, ARefusedProfileDoesNotAffectTheOthers) {
    // The runtime refuses the simple controller, with all bindings and with only the required ones.
    useScenario(R"("events": [{"t_s": 0, "refuse": {"call": "xrSuggestInteractionProfileBindings", "times": 2,
        "result": "XR_ERROR_PATH_UNSUPPORTED"}}],
        "controllers": {"profile": "/interaction_profiles/htc/vive_controller", "right": {}})");
    RenderLoop loop;
    ASSERT_EQ(loop.session.notes().size(), 1u);
    EXPECT_THAT(
        loop.session.notes()[0],
        HasSubstr("XR_ERROR_PATH_UNSUPPORTED: the runtime takes no /interaction_profiles/khr/simple"));
    loop.run(8);
    EXPECT_EQ(loop.session.facts().profiles[1], "/interaction_profiles/htc/vive_controller");
    EXPECT_TRUE(loop.session.hand(1).active);
}

TEST_F(InputTest, WithoutFocusNoInputIsRead) {
    useScenario(R"("session": [{"t_s": 0, "state": "focused"}, {"t_s": 1.15, "state": "visible"}],
        "controllers": {"right": {"values": [{"t_s": 0, "select/click": true}]}})");
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.frame();
    EXPECT_TRUE(loop.session.hand(1).select);
    ASSERT_TRUE(loop.runUntil(SessionPhase::visible, 40));
    loop.frame();
    EXPECT_FALSE(loop.session.hand(1).active);
    EXPECT_FALSE(loop.session.hand(1).select);
    EXPECT_FALSE(loop.session.gripAt(1, 0).has_value());
}

TEST_F(InputTest, ABareHandGripsAndPinches) {
    useScenario(R"("controllers": {}, "hands": {"right": {
        "poses": [{"t_s": 0, "position": [0.2, 1.2, -0.4]}],
        "curls": [{"t_s": 0, "thumb": 0, "index": 0, "middle": 0, "ring": 0, "little": 0},
                  {"t_s": 1.2, "thumb": 0, "index": 0},
                  {"t_s": 1.3, "thumb": 0.75, "index": 0.65},
                  {"t_s": 1.5, "thumb": 0.75, "index": 0.65},
                  {"t_s": 1.6, "thumb": 0, "index": 0}],
        "tracked": [{"t_s": 0, "tracked": true}, {"t_s": 1.8, "tracked": false}]}})");
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.frame();
    const Hand open = loop.session.hand(1);
    EXPECT_FALSE(loop.session.hand(0).active);
    ASSERT_TRUE(open.active && open.bare);
    EXPECT_FALSE(open.select);
    ASSERT_TRUE(open.stage_from_grip && open.stage_from_aim);
    EXPECT_NEAR(open.stage_from_grip->position_m.x, 0.2, 1e-5);
    EXPECT_LT(open.stage_from_aim->position_m.z, -0.45) << "the fingers are ahead of the palm";
    const auto at = loop.session.gripAt(1, 0);
    ASSERT_TRUE(at.has_value());
    EXPECT_NEAR(at->position_m.y, 1.2, 1e-5);
    bool pinched = false, let_go = false;
    for (int i = 0; i < 60; ++i) {
        loop.run(1);
        pinched |= loop.session.hand(1).select;
        let_go |= pinched && !loop.session.hand(1).select;
    }
    EXPECT_TRUE(pinched);
    EXPECT_TRUE(let_go);
    EXPECT_FALSE(loop.session.hand(1).menu);
    loop.run(40);
    EXPECT_FALSE(loop.session.hand(1).active);
    EXPECT_FALSE(loop.session.gripAt(1, 0).has_value());
}

// The thumb touches the middle finger, then the ring finger.
TEST_F(InputTest, ABareHandHasAMenuAndASqueeze) {
    constexpr int kThumbTip = 5, kMiddleTip = 15, kRingTip = 20;  // XrHandJointEXT
    const auto joints = [](int near_thumb) {
        std::string text;
        for (int joint = 0; joint < 26; ++joint) {
            const bool meets = joint == near_thumb || joint == kThumbTip;
            text += std::string(joint > 0 ? "," : "") + "[" + (meets ? "0" : std::to_string(0.1 * joint)) +
                    (joint == near_thumb ? ",1.21" : ",1.2") + ",-0.4,0,0,0,1,0.01]";
        }
        return "[" + text + "]";
    };
    useScenario(R"("controllers": {}, "hands": {"left": {"joints": [{"t_s": 0, "joints": )" +
                joints(kMiddleTip) + R"(}, {"t_s": 1.5, "joints": )" + joints(kMiddleTip) +
                R"(}, {"t_s": 1.6, "joints": )" + joints(kRingTip) + "}]}}");
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.frame();
    EXPECT_TRUE(loop.session.hand(0).menu);
    EXPECT_EQ(loop.session.hand(0).squeeze, 0.0f);
    EXPECT_FALSE(loop.session.hand(0).select);
    loop.run(80);
    EXPECT_FALSE(loop.session.hand(0).menu);
    EXPECT_EQ(loop.session.hand(0).squeeze, 1.0f);
}

TEST_F(InputTest, HandTrackingNeedsSystemSupport) {
    useScenario(R"("controllers": {}, "hands": {"supported": false})");
    {
        RenderLoop loop;
        loop.run(10);
        EXPECT_FALSE(loop.session.hand(0).active);
    }
    EXPECT_THAT(calls("xrCreateHandTrackerEXT"), IsEmpty());
}

// A second thread reads the grip pose continuously while frames begin and end.
TEST_F(InputTest, GripPosesCanBeReadFromAnyThreadAtAnyTime) {
    useScenario(R"("controllers": {"right": {"poses": [{"t_s": 0, "position": [0, 1, 0]},
        {"t_s": 100, "position": [100, 1, 0]}]}})");
    setVariable("XRMOCK_CLOCK", "real");
    RenderLoop loop(SessionSettings{});
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused, 400));
    loop.frame();
    std::atomic<bool> stop{false};
    std::atomic<int> found{0}, wrong{0};
    std::thread reader([&] {
        double before_m = -1.0;
        std::int64_t before_ns = 0;
        while (!stop) {
            timespec now{};
            clock_gettime(CLOCK_MONOTONIC, &now);
            const std::int64_t now_ns = std::int64_t(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
            const auto pose = loop.session.gripAt(1, now_ns);
            if (!pose) continue;
            // The hand moves at one metre per second, and the reported poses must too.
            const double moved_m = pose->position_m.x - before_m;
            if (found > 0 && std::abs(moved_m - 1e-9 * double(now_ns - before_ns)) > 1e-4) ++wrong;
            before_m = pose->position_m.x;
            before_ns = now_ns;
            ++found;
        }
    });
    loop.run(20);
    const Frame frame = loop.frame();
    const auto shown_at = loop.session.monotonic_ns(frame.predicted_display_time_ns);
    stop = true;
    reader.join();
    EXPECT_GT(found, 10);
    EXPECT_EQ(wrong, 0);
    EXPECT_EQ(shown_at, frame.predicted_display_time_ns) << "this runtime's time is CLOCK_MONOTONIC";
}

TEST_F(InputTest, AVirtualClockHasNoMonotonicTime) {
    RenderLoop loop;
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    const Frame frame = loop.frame();
    EXPECT_FALSE(loop.session.monotonic_ns(frame.predicted_display_time_ns).has_value());
    const auto grip = loop.session.gripAt(1, 12345);
    ASSERT_TRUE(grip.has_value());
    EXPECT_NEAR(grip->position_m.x, 0.25, 1e-6);
}

TEST_F(InputTest, WithoutTimeConversionTheGripIsThatOfTheLastFrame) {
    setVariable("XRMOCK_WITHHOLD", "XR_KHR_convert_timespec_time");
    RenderLoop loop(SessionSettings{});
    EXPECT_FALSE(loop.session.gripAt(1, 12345).has_value()) << "there was no frame yet";
    ASSERT_TRUE(loop.runUntil(SessionPhase::focused));
    loop.frame();
    EXPECT_TRUE(loop.session.gripAt(1, 12345).has_value());
    EXPECT_FALSE(loop.session.monotonic_ns(1'000'000'000).has_value());
}

}  // namespace
}  // namespace stylet::xr
