// Uses the mock runtime's controllers as the input of an attempt, with a headset and no haptic device.
#include "app/trainer/hands/controller_hand.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/display/frames.h"
#include "app/trainer/hands/live_hand.h"
#include "app/trainer/stores/platform_linux.h"
#include "tests/app/trainer/difficulties.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;

json keyOf(double t_s, const Pose& p) {
    return {{"t_s", t_s},
            {"position", {p.position_m.x, p.position_m.y, p.position_m.z}},
            {"orientation", {p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w}}};
}

class ControllerHand : public testing::Test {
  protected:
    ControllerHand() {
        setenv("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST, 1);
        setenv("XRMOCK_LOG", (folder_ / "log.jsonl").c_str(), 1);
    }
    ~ControllerHand() override {
        unsetenv("XRMOCK_LOG");
        unsetenv("XRMOCK_SCENARIO");
    }
    void play(const json& controllers, const json& events = json::array()) {
        const json head = json::array({keyOf(0.0, stageFromHead(stage_from_patient_, fieldOf(path_), 0.0))});
        std::ofstream(folder_ / "scenario.json") << json{{"version", 2},
                                                         {"eyes", {{"recommended_size", {64, 64}}}},
                                                         {"head", head},
                                                         {"controllers", controllers},
                                                         {"events", events}};
        setenv("XRMOCK_SCENARIO", (folder_ / "scenario.json").c_str(), 1);
    }
    // The grip pose that puts the needle's tip at this depth on the path.
    Pose gripAt(double depth_m) const {
        const Pose room_from_tool = stage_from_patient_ * needlePose({depth_m, 0.0, 0.0}, {1.0, 0.0, 0.0});
        return {room_from_tool.rotation, room_from_tool * Vec3(0.0, 0.0, 0.15)};
    }
    int calls(const std::string& name) const {
        int count = 0;
        std::ifstream log(folder_ / "log.jsonl");
        for (std::string line; std::getline(log, line);)
            count += line.find("\"call\":\"" + name + "\"") != std::string::npos;
        return count;
    }

    const patient::Package package_ = test::ductPhantom();
    const patient::Patient patient_{package_};
    const patient::PlannedPath path_ = test::ductPath();
    const Pose stage_from_patient_ = stageFromPatient(patient_, fieldOf(path_));
    test::TempFolder folder_;
};

// The haptics loop and the frame loop run in threads of their own. The mock runtime's clock advances by a
// fixed time per frame, however long the frame takes. The scripted controller therefore moves about 0.25 mm
// per frame.
TEST_F(ControllerHand, PuncturesTheDuctAlongThePlannedPath) {
    play(
        {{"right",
          {{"poses", {keyOf(0.0, gripAt(-0.005)), keyOf(1.5, gripAt(-0.005)), keyOf(4.1, gripAt(0.054))}}}}});
    const auto port = std::make_shared<ControllerPort>();
    const haptics::Clock clock = monotonicClock();
    const Scenario scenario = test::shortScenario();
    Attempt attempt = makeLiveAttempt(patient_, scenario, path_, fieldOf(path_), {},
                                      haptics::makeTouchMap(patient_), {.profile = controllerProfile()});
    attempt.simulation.patient_from_device = stage_from_patient_.inverse();
    LiveDevice device(kControllers, std::make_unique<ControllerDriver>(*port, ControllerSide::right, clock),
                      clock);
    PictureSettings settings;
    settings.field = fieldOf(path_);
    settings.config.difficulties = test::difficulties();
    settings.assets = std::getenv("STYLET_ASSETS");
    settings.controllers = port;
    settings.config.validation = true;
    settings.config.fast = true;
    std::string why_not;
    auto pictures = openPictures(patient_, path_, settings, why_not);
    ASSERT_TRUE(pictures) << why_not;
    Session session(patient_, path_, {}, 0.0, nullptr);
    Vibrations vibrations;
    const LiveHand hand{device.bare(),
                        [&](double elapsed_s) { return elapsed_s > 150.0 || session.log().target_hit(); },
                        [] { return std::string(); },
                        [](haptics::Tool) {},
                        device.buttons(),
                        device.rearmAct(),
                        [&](const haptics::TickOutput& newest) {
                            if (const auto felt = vibrations.update(newest)) port->vibrate(*felt);
                        }};
    const LoopTotals totals = runRealTime(attempt, session, std::move(pictures), clock, {.live = &hand});
    device.stop();
    EXPECT_TRUE(session.log().target_hit());
    EXPECT_EQ(totals.pictures.validation_messages, 0u);
    EXPECT_EQ(session.log().faults & haptics::kFaultOverSpeed, 0u);
    // The duct's near wall lies on the planned path at x = 50 mm. The puncture is expected 0.3 mm deeper,
    // where the tenting force reaches the wall's cut force in the force table.
    ASSERT_TRUE(session.log().target_cut);
    const Vec3 tip_m = session.log().target_cut->patient_from_needle.position_m;
    EXPECT_NEAR(tip_m.x, 0.0503, 1e-3);
    EXPECT_NEAR(glm::length(Vec3(0.0, tip_m.y, tip_m.z)), 0.0, 1e-4);
    // The contact and each puncture request a vibration of the controller. All requests within one frame
    // result in a single call, so only one call is certain.
    EXPECT_GE(calls("xrApplyHapticFeedback"), 1);
}

// The tool pose must come from the controller named in the settings ("left"). The tool must disappear when
// the OpenXR session is lost or ends, and reappear with the next session. The test runs single frames on the
// mock runtime's virtual clock.
TEST_F(ControllerHand, FollowsTheSelectedHandWhileTheSessionHasFocus) {
    const Pose left = gripAt(-0.05), right = gripAt(-0.10);
    play({{"left", {{"poses", {keyOf(0.0, left)}}}}, {"right", {{"poses", {keyOf(0.0, right)}}}}},
         {{{"frame", 12}, {"session_loss", {{"lost_after_s", 0}}}}});
    PictureSettings settings;
    settings.field = fieldOf(path_);
    settings.config.difficulties = test::difficulties();
    settings.assets = std::getenv("STYLET_ASSETS");
    settings.config.fast = true;
    settings.controllers = std::make_shared<ControllerPort>();
    settings.config.hand = "left";
    ControllerPort& port = *settings.controllers;
    {
        FrameLoop loop(patient_, settings, path_);
        FrameState seen;
        seen.tick.patient_from_needle.position_m = {-0.05, 0.0, 0.0};
        std::uint32_t buttons = 0;
        const auto tool = [&] { return port.toolAt(0, buttons); };
        for (int i = 0; i < 10; ++i)
            ASSERT_TRUE(loop.frame(seen, nullptr, ""));
        ASSERT_TRUE(tool());
        EXPECT_NEAR(glm::length(tool()->position_m - stage_from_patient_ * Vec3(-0.05, 0.0, 0.0)), 0.0, 1e-4);
        bool lost = false, back = false;
        for (int i = 0; i < 20 && !back; ++i) {
            play({{"left", {{"poses", {keyOf(0.0, right)}}}}});  // for the next session
            ASSERT_TRUE(loop.frame(seen, nullptr, ""));
            lost = lost || !tool();
            back = lost && tool().has_value();
        }
        EXPECT_TRUE(lost && back);
        // In the first frames of the new session the controller's actions are not yet bound, so the tool
        // follows the tracked bare hand. Run two more frames until it follows the controller.
        for (int i = 0; i < 2; ++i)
            ASSERT_TRUE(loop.frame(seen, nullptr, ""));
        EXPECT_NEAR(glm::length(tool()->position_m - stage_from_patient_ * Vec3(-0.10, 0.0, 0.0)), 0.0, 1e-4);
    }
    std::uint32_t buttons = 0;
    EXPECT_FALSE(port.toolAt(0, buttons));  // the session is gone
}

}  // namespace
}  // namespace stylet::trainer
