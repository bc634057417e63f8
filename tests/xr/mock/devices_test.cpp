// Controllers and hands of a scenario: connections, profiles, values and poses over time.
#include <cmath>
#include <fstream>
#include <random>

#include <nlohmann/json.hpp>

#include "tests/xr/mock/client/actions_client.h"

namespace mock_test {
namespace {

constexpr XrTime kSecond = 1'000'000'000;

class Devices : public Actions {
  protected:
    // Runs frames until the display time reaches `time`.
    void runUntil(XrTime time) {
        while (frame().predictedDisplayTime < time) {
        }
    }
};

TEST_F(Devices, ConnectDisconnectAndChangeProfile) {
    setScript(R"({"version": 2, "refresh_hz": 100, "controllers": {
        "left": {"profile": [{"t_s": 0, "profile": "/interaction_profiles/khr/simple_controller"},
                             {"t_s": 1.5, "profile": null},
                             {"t_s": 2, "profile": "/interaction_profiles/oculus/touch_controller"},
                             {"t_s": 3, "profile": "/interaction_profiles/oculus/touch_controller"}],
                 "poses": [{"t_s": 0, "position": [0, 1, 0]}]}},
        "events": [{"t_s": 2.5, "interaction_profile": "/interaction_profiles/khr/simple_controller"}]})");
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrAction grip = action(set, "grip", XR_ACTION_TYPE_POSE_INPUT);
    const XrAction menu = action(set, "menu", XR_ACTION_TYPE_BOOLEAN_INPUT);
    for (const char* each : {kSimple, kTouch}) {
        ASSERT_EQ(suggest(each, {{grip, "/user/hand/left/input/grip/pose"},
                                 {menu, "/user/hand/left/input/menu/click"}}),
                  XR_SUCCESS);
    }
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    const XrSpace space = actionSpace(grip);
    EXPECT_EQ(profile(kLeft), "");
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_EQ(profile(kLeft), kSimple);
    EXPECT_EQ(profile(kRight), "");
    EXPECT_TRUE(poll(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).has_value());

    runUntil(kSecond * 16 / 10);
    EXPECT_EQ(profile(kLeft), kSimple);
    EXPECT_TRUE(poseActive(grip));
    EXPECT_EQ(locate(space, kSecond * 16 / 10).locationFlags, 0U);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_EQ(profile(kLeft), "");
    EXPECT_FALSE(poseActive(grip) || boolean(menu).isActive);
    EXPECT_TRUE(poll(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED).has_value());

    runUntil(kSecond * 21 / 10);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_EQ(profile(kLeft), kTouch);
    EXPECT_TRUE(poseActive(grip) && boolean(menu).isActive);
    EXPECT_NE(locate(space, kSecond * 21 / 10).locationFlags, 0U);

    runUntil(kSecond * 26 / 10);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_EQ(profile(kLeft), kSimple);
    EXPECT_EQ(profile(kRight), "");  // without a controller there is no profile
    runUntil(kSecond * 31 / 10);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_EQ(profile(kLeft), kTouch);
}

TEST_F(Devices, HeadAndGamepadHaveValuesOfTheirOwn) {
    setScript(R"({"version": 2, "refresh_hz": 100, "controllers": {
        "head": {"profile": "/interaction_profiles/htc/vive_pro",
                 "values": [{"t_s": 1.2, "mute_mic/click": true}]},
        "gamepad": {"profile": "/interaction_profiles/microsoft/xbox_controller",
                    "values": [{"t_s": 0, "trigger_left/value": 0.25, "thumbstick_right/y": -1}]}}})");
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrPath head = path("/user/head"), gamepad = path("/user/gamepad");
    const XrAction mute = action(set, "mute", XR_ACTION_TYPE_BOOLEAN_INPUT, {head, gamepad});
    const XrAction trigger = action(set, "trigger", XR_ACTION_TYPE_FLOAT_INPUT);
    const XrAction stick = action(set, "stick", XR_ACTION_TYPE_VECTOR2F_INPUT);
    ASSERT_EQ(suggest("/interaction_profiles/htc/vive_pro", {{mute, "/user/head/input/mute_mic/click"}}),
              XR_SUCCESS);
    ASSERT_EQ(suggest("/interaction_profiles/microsoft/xbox_controller",
                      {{trigger, "/user/gamepad/input/trigger_left"},
                       {stick, "/user/gamepad/input/thumbstick_right"},
                       {mute, "/user/gamepad/input/a/click"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_EQ(profile("/user/head"), "/interaction_profiles/htc/vive_pro");
    EXPECT_EQ(profile("/user/gamepad"), "/interaction_profiles/microsoft/xbox_controller");
    EXPECT_EQ(profile("/user/treadmill"), "");
    EXPECT_EQ(number(trigger).currentState, 0.25F);
    EXPECT_EQ(vector(stick).currentState.y, -1.0F);
    EXPECT_FALSE(boolean(mute, head).currentState);
    runUntil(kSecond * 12 / 10);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_TRUE(boolean(mute, head).currentState);
    EXPECT_TRUE(boolean(mute, gamepad).isActive);
    EXPECT_FALSE(boolean(mute, gamepad).currentState);
    EXPECT_EQ(boolean(mute, head).lastChangeTime, kSecond * 12 / 10);
}

// lastChangeTime is the time of the change at the device, not the time of the xrSyncActions that reported
// it.
TEST_F(Devices, ChangesCarryTheirTime) {
    setScript(R"({"version": 2, "refresh_hz": 100, "controllers": {"left": {"values": [
        {"t_s": 1.104, "select/click": true}, {"t_s": 1.106, "select/click": true},
        {"t_s": 1.206, "select/click": false}, {"t_s": 1.207, "select/click": true}]}}})");
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrAction press = action(set, "press", XR_ACTION_TYPE_BOOLEAN_INPUT);
    ASSERT_EQ(suggest(kSimple, {{press, "/user/hand/left/input/select/click"}}), XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    runUntil(kSecond * 115 / 100);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_TRUE(boolean(press).changedSinceLastSync);
    EXPECT_EQ(boolean(press).lastChangeTime, 1'104'000'000);
    runUntil(kSecond * 121 / 100);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    EXPECT_TRUE(boolean(press).currentState);
    EXPECT_FALSE(boolean(press).changedSinceLastSync);
    EXPECT_EQ(boolean(press).lastChangeTime, 1'104'000'000);
}

// Priorities apply to each source of each hand separately, even if a set is active for one hand only.
TEST_F(Devices, ASetActiveOnOneHandReceivesOnlyItsSource) {
    startFocused();
    const XrPath left = path(kLeft), right = path(kRight);
    const XrActionSet high = actionSet("high", 3), low = actionSet("low", 2);
    const XrAction high_select = action(high, "high_select", XR_ACTION_TYPE_BOOLEAN_INPUT, {left, right});
    const XrAction low_select = action(low, "low_select", XR_ACTION_TYPE_BOOLEAN_INPUT, {left, right});
    const XrAction low_both = action(low, "low_both", XR_ACTION_TYPE_BOOLEAN_INPUT, {left, right});
    ASSERT_EQ(suggest(kSimple, {{high_select, "/user/hand/left/input/select/click"},
                                {high_select, "/user/hand/right/input/select/click"},
                                {low_select, "/user/hand/left/input/select/click"},
                                {low_select, "/user/hand/right/input/select/click"},
                                {low_both, "/user/hand/left/input/select/click"},
                                {low_both, "/user/hand/left/input/menu/click"},
                                {low_both, "/user/hand/right/input/select/click"},
                                {low_both, "/user/hand/right/input/menu/click"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({high, low}), XR_SUCCESS);
    const auto syncWith = [&](const std::vector<XrActiveActionSet>& active) {
        const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr,
                                     static_cast<std::uint32_t>(active.size()), active.data()};
        ASSERT_EQ(xrSyncActions(session_, &info), XR_SUCCESS);
    };
    const auto activity = [&](XrAction each) {
        return std::array<bool, 3>{boolean(each).isActive == XR_TRUE, boolean(each, left).isActive == XR_TRUE,
                                   boolean(each, right).isActive == XR_TRUE};
    };
    using On = std::array<bool, 3>;  // without subaction path, left, right
    syncWith({{low, left}, {low, right}, {high, left}, {high, right}});
    EXPECT_EQ(activity(high_select), (On{true, true, true}));
    EXPECT_EQ(activity(low_select), (On{false, false, false}));
    EXPECT_EQ(activity(low_both), (On{true, true, true}));
    syncWith({{high, right}, {low, left}});
    EXPECT_EQ(activity(high_select), (On{true, false, true}));
    EXPECT_EQ(activity(low_select), (On{true, true, false}));
    EXPECT_EQ(activity(low_both), (On{true, true, false}));
    syncWith({{high, right}, {low, left}, {low, right}});
    EXPECT_EQ(activity(low_select), (On{true, true, false}));
    EXPECT_EQ(activity(low_both), (On{true, true, true}));
}

TEST_F(Devices, RecordedPosesMoveTheHand) {
    std::ofstream(file("hand.csv")) << "t_s,x,y,z,qx,qy,qz,qw\n0,0,1,0,0,0,0,1\n1,1,1,0,0,0,0,1\r\n"
                                       "2,1,1,0,0,0.7071067811865476,0,0.7071067811865476\n";
    setScript(R"({"version": 2, "controllers": {"right": {"poses": {"csv": "hand.csv"}}}})");
    startFocused();
    const XrActionSet set = actionSet("set");
    const XrAction grip = action(set, "grip", XR_ACTION_TYPE_POSE_INPUT);
    ASSERT_EQ(suggest(kSimple, {{grip, "/user/hand/right/input/grip/pose"}}), XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    const XrSpace space = actionSpace(grip),
                  tip = actionSpace(grip, XR_NULL_PATH, {{0, 0, 0, 1}, {0, 0, -1}});
    EXPECT_FLOAT_EQ(locate(space, kSecond / 4).pose.position.x, 0.25F);
    auto velocity = makeStruct<XrSpaceVelocity>(XR_TYPE_SPACE_VELOCITY);
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    location.next = &velocity;
    ASSERT_EQ(xrLocateSpace(space, stage_, kSecond / 2, &location), XR_SUCCESS);
    EXPECT_NEAR(velocity.linearVelocity.x, 1, 1e-6);
    ASSERT_EQ(xrLocateSpace(tip, stage_, kSecond * 3 / 2, &location), XR_SUCCESS);
    EXPECT_NEAR(velocity.angularVelocity.y, 1.570796, 1e-5);
    // A point 1 m along -z of a hand turned by 45 degrees. Its velocity is the cross product of angular
    // velocity and lever arm.
    EXPECT_NEAR(velocity.linearVelocity.x, -1.570796 * std::sqrt(0.5), 1e-5);
    EXPECT_NEAR(velocity.linearVelocity.z, 1.570796 * std::sqrt(0.5), 1e-5);
}

TEST_F(Devices, InvalidDescriptionsAreRefused) {
    const auto refusal = [&](const std::string& text) {
        setScript(R"({"version": 2, )" + text + "}");
        testing::internal::CaptureStderr();
        EXPECT_EQ(tryInstance(), XR_ERROR_RUNTIME_FAILURE) << text;
        const std::string output = testing::internal::GetCapturedStderr();
        const std::string start = "xrmock: " + file("scenario.json").string() + ": ";
        const std::size_t at = output.find(start);
        return at == std::string::npos
                   ? output
                   : output.substr(at + start.size(), output.find('\n', at) - at - start.size());
    };
    EXPECT_EQ(refusal(R"("controllers": {"left": {"values": [{"t_s": 0, "select/clack": 1}]}})"),
              "controllers.left.values[0].select/clack: unknown component");
    EXPECT_EQ(refusal(R"("controllers": {"left": {"profile": "/interaction_profiles/htc/vive_pro"}})"),
              "controllers.left.profile: not a profile of this user path");
    EXPECT_EQ(
        refusal(R"("events": [{"t_s": 0, "interaction_profile": "/interaction_profiles/htc/vive_pro"}])"),
        "events[0].interaction_profile: not a profile of hands");
    EXPECT_EQ(refusal(R"("controllers": {"gamepad": {}})"), "controllers.gamepad: profile is missing");
    EXPECT_EQ(refusal(R"("controllers": {"left": {"profile": []}})"),
              "controllers.left.profile: at least one key expected");
    EXPECT_EQ(refusal(R"("hands": {"left": {"curls": [{"t_s": 0, "index": 1.5}]}})"),
              "hands.left.curls[0].index: a number from 0 to 1 expected");
    EXPECT_EQ(refusal(R"("hands": {"left": {"joints": [{"t_s": 0, "joints": [[1]]}]}})"),
              "hands.left.joints[0].joints: 26 joints expected");
    const std::string heading = "t_s,x,y,z,qx,qy,qz,qw\n";
    const auto csv = [&](const std::string& content) {
        std::ofstream(file("bad.csv")) << content;
        return refusal(R"("controllers": {"left": {"poses": {"csv": "bad.csv"}}})");
    };
    const std::string place = "controllers.left.poses.csv: bad.csv line ";
    EXPECT_EQ(csv("t,x,y,z\n"), place + "1: the heading is not the one expected");
    EXPECT_EQ(csv(heading), place + "1: at least one line below the heading expected");
    EXPECT_EQ(csv(heading + "0,0,0,0,0,0,0\n"),
              place + "2: as many numbers as the heading has names expected");
    EXPECT_EQ(csv(heading + "0,0,0,0,0,0,0,x\n"),
              place + "2: as many numbers as the heading has names expected");
    EXPECT_EQ(csv(heading + "0,0,0,0,0,0,0,2\n"), place + "2: a unit quaternion x y z w expected");
    EXPECT_EQ(csv(heading + "1,0,0,0,0,0,0,1\n1,0,0,0,0,0,0,1\n"),
              place + "3: later than the line before expected");
}

// A vibration ends when the next one starts on the same output, when its action is stopped, or when focus
// is lost.
TEST_F(Devices, VibrationsAreRecordedPerOutput) {
    setVariable("XRMOCK_LOG", file("log.jsonl").string());
    startFocused();
    const XrPath left = path(kLeft), right = path(kRight);
    const XrActionSet set = actionSet("set");
    const XrAction buzz = action(set, "buzz", XR_ACTION_TYPE_VIBRATION_OUTPUT, {left, right});
    const XrAction other = action(set, "other", XR_ACTION_TYPE_VIBRATION_OUTPUT);
    ASSERT_EQ(suggest(kSimple, {{buzz, "/user/hand/left/output/haptic"},
                                {buzz, "/user/hand/right/output/haptic"},
                                {other, "/user/hand/left/output/haptic"}}),
              XR_SUCCESS);
    ASSERT_EQ(attach({set}), XR_SUCCESS);
    ASSERT_EQ(sync({set}), XR_SUCCESS);
    const auto apply = [&](XrAction each, XrPath subaction, XrDuration duration, float amplitude) {
        const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, each, subaction};
        const XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION, nullptr, duration, 200, amplitude};
        ASSERT_EQ(
            xrApplyHapticFeedback(session_, &info, reinterpret_cast<const XrHapticBaseHeader*>(&vibration)),
            XR_SUCCESS);
    };
    const auto stop = [&](XrAction each, XrPath subaction) {
        const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, each, subaction};
        ASSERT_EQ(xrStopHapticFeedback(session_, &info), XR_SUCCESS);
    };
    const XrTime before = frame().predictedDisplayTime;
    apply(buzz, XR_NULL_PATH, 2 * kSecond, 0.25F);          // both hands
    apply(other, XR_NULL_PATH, XR_MIN_HAPTIC_DURATION, 7);  // interrupts the left one
    stop(buzz, left);                                       // no effect: it no longer plays on the left
    stop(other, XR_NULL_PATH);
    apply(buzz, left, kSecond, 0.5F);
    frame();

    std::ifstream log(file("log.jsonl"));
    std::vector<nlohmann::json> pulses, paths;
    for (std::string line; std::getline(log, line);) {
        const auto entry = nlohmann::json::parse(line);
        if (entry.value("call", "") == "xrApplyHapticFeedback") paths.push_back(entry["args"][1]["path"]);
        if (!entry.contains("haptic_pulses")) continue;
        for (const auto& pulse : entry["haptic_pulses"])
            pulses.push_back(pulse);
    }
    const auto expect = [&](std::size_t i, const char* name, const char* user, XrDuration lasts,
                            double amplitude) {
        EXPECT_EQ(pulses[i]["action"], name) << i;
        EXPECT_EQ(pulses[i]["user"], user) << i;
        EXPECT_EQ(pulses[i]["start"], before) << i;
        EXPECT_EQ(pulses[i]["end"], before + lasts) << i;
        EXPECT_EQ(pulses[i]["amplitude"], amplitude) << i;
        EXPECT_EQ(pulses[i]["frequency_hz"], 200) << i;
    };
    EXPECT_EQ(paths, (std::vector<nlohmann::json>{nullptr, nullptr, kLeft}));
    ASSERT_EQ(pulses.size(), 4U);
    expect(0, "buzz", kLeft, 0, 0.25);
    expect(1, "buzz", kRight, 2 * kSecond, 0.25);
    expect(2, "other", kLeft, 0, 1);
    expect(3, "buzz", kLeft, kSecond, 0.5);
}

// Damaged devices and hands are either rejected or accepted. Accepted ones must be usable.
TEST_F(Devices, DamagedDescriptionsDoNotCrash) {
    std::string joints;
    for (int i = 0; i < XR_HAND_JOINT_COUNT_EXT; ++i)
        joints += (i == 0 ? "[" : ",[") + std::to_string(i) + ",0,0,0,0,0,1,0.01]";
    const std::string whole =
        R"({"version":2,"controllers":{"profile":"/interaction_profiles/khr/simple_controller","left":{"poses":)"
        R"([{"t_s":0,"position":[0,0,0]}],"grip_from_aim":{"position":[0,0,0]},"values":[{"t_s":1,)"
        R"("select/click":true}],"profile":[{"t_s":0,"profile":null}]},"gamepad":{"profile":null}},"hands":)"
        R"({"left":{"curls":[{"t_s":0,"index":0.5},{"t_s":1,"thumb":1}],"tracked":[{"t_s":1,"tracked":true}]},)"
        R"("right":{"joints":[{"t_s":0,"joints":[)" +
        joints + "]}]}}}";
    std::mt19937 random(11);
    testing::internal::CaptureStderr();
    int taken = 0;
    for (int i = 0; i < 300; ++i) {
        std::string damaged = whole;
        for (unsigned edits = random() % 3; edits > 0; --edits) {
            const std::size_t at = random() % damaged.size();
            if (random() % 2 == 0)
                damaged[at] = static_cast<char>(random() % 96 + 32);
            else
                damaged.insert(at, damaged.substr(random() % damaged.size(), random() % 16));
        }
        setScript(damaged);
        const XrResult result = tryInstance();
        EXPECT_TRUE(result == XR_SUCCESS || result == XR_ERROR_RUNTIME_FAILURE) << damaged;
        taken += result == XR_SUCCESS;
        if (result == XR_SUCCESS) xrDestroyInstance(instance_);
        instance_ = XR_NULL_HANDLE;
    }
    testing::internal::GetCapturedStderr();
    EXPECT_GT(taken, 50);
    EXPECT_LT(taken, 250);
}

}  // namespace
}  // namespace mock_test
