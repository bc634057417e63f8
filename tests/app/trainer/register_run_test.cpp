// `stylet register` as a user meets it: an emulated device behind its socket, the mock runtime's controller
// with its tip on the device's, and what is kept against where the device really stands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <fstream>
#include <glm/gtc/quaternion.hpp>

#include "app/trainer/register.h"
#include "tests/app/trainer/command.h"
#include "tests/support/bridge_emulator.h"
#include "tests/support/decimal_comma.h"
#include "tests/support/mock_control.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using patient::Pose;
using patient::Quat;
using patient::Vec3;
using test::Command;
using test::MockControl;
using test::Outcome;
using testing::HasSubstr;

constexpr std::chrono::milliseconds kPatience = std::chrono::seconds(60);

// Where the emulated device stands, how its controller is held.
struct Place {
    Pose stage_from_device{glm::angleAxis(0.6, glm::normalize(Vec3(0.2, 1.0, 0.1))), {0.15, 0.95, -0.45}};
    Vec3 grip_from_tip_m{0.005, -0.03, -0.11};

    Pose gripOf(const Vec3& device_tip_m, const Quat& turn) const {
        return {turn, stage_from_device * device_tip_m - turn * grip_from_tip_m};
    }
};

json jsonOf(const Pose& p) {
    const Quat& q = p.rotation;
    return {{"position", {p.position_m.x, p.position_m.y, p.position_m.z}},
            {"orientation", {q.x, q.y, q.z, q.w}}};
}

std::array<double, 7> stylusAt(const Vec3& p, const Quat& q = {1, 0, 0, 0}) {
    return {p.x, p.y, p.z, q.w, q.x, q.y, q.z};
}

Quat turned(double t_s, double size) {
    return glm::angleAxis(size * std::sin(2.1 * t_s), Vec3(1, 0, 0)) *
           glm::angleAxis(size * std::sin(3.3 * t_s), Vec3(0, 0, 1));
}

// Both hands, and eyes that read what the program says.
class User {
  public:
    User(const std::string& control, std::filesystem::path said, test::BridgeServer& device,
         const Place& place_in)
        : place(place_in), mock_(control), said_(std::move(said)), device_(device) {
        rest(kStart_m);
    }

    // Until the program has said this, after what it was last waited for. False when it does not.
    bool hear(const std::string& words, std::chrono::milliseconds patience = kPatience) {
        const auto deadline = std::chrono::steady_clock::now() + patience;
        while (std::chrono::steady_clock::now() < deadline) {
            const std::string all = test::textOf(said_);
            const std::size_t found = all.find(words, heard_);
            if (found != std::string::npos) {
                heard_ = found + words.size();
                return true;
            }
            nap(20);
        }
        return false;
    }
    void mustHear(const std::string& words) {
        if (!hear(words)) throw std::runtime_error("never said: " + words + "\n" + test::textOf(said_));
    }
    // Held until it had its effect; again where a starved machine missed it.
    void press(const std::string& until, const std::string& button = "select/click") {
        for (int tries = 0; tries < 5; ++tries) {
            value(button, true);
            const bool heard = hear(until, std::chrono::seconds(6));
            value(button, false);
            nap(250);
            if (heard) return;
        }
        mustHear(until);
    }
    void rest(const Vec3& tip_m, const Quat& turn = {1, 0, 0, 0}, const Quat& stylus = {1, 0, 0, 0}) {
        device_.follow([=](std::int64_t) { return stylusAt(tip_m, stylus); });
        apply({{"poses", json::array({jsonOf(place.gripOf(tip_m, turn))})}});
        nap(150);
    }
    // The controller's tip stays, the controller turns.
    void turnAbout(const Vec3& tip_m, double seconds) {
        play(seconds, [&](double t_s) { return place.gripOf(tip_m, turned(t_s, 0.6)); });
    }
    // Everywhere, both together.
    void sweep(double seconds) {
        const auto tipAt = [](double t_s) {
            return kStart_m + 0.04 * std::min(1.0, 0.5 * t_s) *
                                  Vec3(std::sin(1.1 * t_s), std::sin(1.7 * t_s), std::sin(2.3 * t_s));
        };
        play(seconds, [&](double t_s) { return place.gripOf(tipAt(t_s), turned(t_s, 0.5)); });
        const std::int64_t begin_ns = test::monotonicNow_ns();
        device_.follow([=](std::int64_t now_ns) {
            const double t_s = 1e-9 * double(now_ns - begin_ns);
            return stylusAt(tipAt(t_s), glm::angleAxis(0.4 * std::sin(0.9 * t_s), Vec3(0, 1, 0)));
        });
    }
    void apply(const json& right) { mock_.ask({{"apply", {{"controllers", {{"right", right}}}}}}); }
    MockControl& mock() { return mock_; }
    static void nap(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

    static constexpr Vec3 kStart_m{0.0, 0.0, 0.1};  // the emulated workspace's middle
    Place place;

  private:
    void value(const std::string& button, bool down) { apply({{"values", json::array({{{button, down}}})}}); }
    template <typename GripAt>
    void play(double seconds, const GripAt& gripAt) {
        const std::filesystem::path csv = said_.parent_path() / "grip.csv";
        std::ofstream file(csv);
        file.precision(12);
        file << "t_s,x,y,z,qx,qy,qz,qw\n";
        for (double t_s = 0.0; t_s < seconds; t_s += 0.01) {
            const Pose p = gripAt(t_s);
            const Quat& q = p.rotation;
            file << t_s << ',' << p.position_m.x << ',' << p.position_m.y << ',' << p.position_m.z << ','
                 << q.x << ',' << q.y << ',' << q.z << ',' << q.w << '\n';
        }
        file.close();
        apply({{"poses", {{"csv", csv.string()}}}});
    }

    MockControl mock_;
    std::filesystem::path said_;
    test::BridgeServer& device_;
    std::size_t heard_ = 0;
};

class RegisterRun : public testing::Test {
  protected:
    void SetUp() override {
        std::ofstream(command_ / "scenario.json") << R"({ "version": 2, "refresh_hz": 90,
            "eyes": { "ipd_m": 0.06, "recommended_size": [64, 48] },
            "head": [{ "t_s": 0, "position": [0, 1.5, 0] }],
            "controllers": { "right": { "profile": "/interaction_profiles/khr/simple_controller",
                                        "poses": [{ "t_s": 0, "position": [0, 1, -0.3] }] } } })";
        command_.set("XR_RUNTIME_JSON", STYLET_MOCK_MANIFEST);
        command_.set("XRMOCK_SCENARIO", (command_ / "scenario.json").string());
        command_.set("XRMOCK_CONTROL", control());
        command_.set("XDG_DATA_HOME", (command_ / "data").string());
    }
    std::string control() const { return (command_ / "control").string(); }

    // The program with this user; he is told when the runtime listens.
    template <typename Acts>
    Outcome run(const std::string& arguments, const Place& place, const Acts& acts) {
        const std::string socket = (command_ / "bridge.sock").string();
        test::BridgeServer device(socket, {});
        device.follow([](std::int64_t) { return stylusAt(User::kStart_m); });
        std::filesystem::remove(command_ / "stderr");
        std::thread hands([&] {
            try {
                User user(control(), command_ / "stderr", device, place);
                acts(user);
            } catch (const std::exception& e) {
                ADD_FAILURE() << e.what();
                giveUp();
            }
        });
        const Outcome outcome = command_.runInto(
            command_ / "kept.json",
            "register --device bridge --socket '" + socket + "' " + arguments + " </dev/null",
            command_ / "number");
        hands.join();
        return outcome;
    }
    void giveUp(int signal = SIGINT) { kill(std::atoi(test::textOf(command_ / "number").c_str()), signal); }

    // The kept one against the truth, all over the cube.
    static void expectRight(const Registration& kept, const Place& place) {
        double squares = 0.0, worst_m = 0.0;
        for (const Vec3& p : xr::registration::spreadPlaces({User::kStart_m, 0.04}, 34)) {
            const double off_m = glm::distance(kept.inStage({{}, p}), place.stage_from_device * p);
            squares += off_m * off_m / 34.0;
            worst_m = std::max(worst_m, off_m);
        }
        EXPECT_LE(std::sqrt(squares), kept.tre_mean_m);
        EXPECT_LE(worst_m, kept.tre_worst_m);
        EXPECT_LT(kept.tre_mean_m, 0.0018);
        EXPECT_LT(glm::distance(kept.grip_from_tip_m, place.grip_from_tip_m), 0.001);
    }
    static void findTip(User& user) {
        user.press("Press the trigger, then turn");
        user.press("Keep turning");
        user.turnAbout(User::kStart_m, 30.0);
    }
    static void touch(User& user, const std::vector<Vec3>& places) {
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double t_s = 0.7 * double(i);
            user.rest(places[i], turned(t_s, 0.4), glm::angleAxis(0.3 * std::sin(t_s), Vec3(0, 1, 0)));
            const bool last = i + 1 == places.size();
            user.press(last ? "to keep it" : "Point " + std::to_string(i + 1) + " is taken");
        }
    }

    Command command_;
};

TEST_F(RegisterRun, PointsAreTouchedAndTheDeviceIsWhereItStands) {
#ifdef STYLET_ROUGH
    // Whoever registers may come from anywhere: what is kept is in metres.
    const auto country = test::decimalComma(command_ / "locales", STYLET_ROUGH);
    ASSERT_FALSE(country.empty()) << "localedef knows no de_DE: the package locales is missing";
    for (const auto& [name, value] : country)
        command_.set(name, value);
#endif
    const Place place;
    const Outcome outcome = run("", place, [&](User& user) {
        user.mustHear("to begin");
        findTip(user);
        user.mustHear("Point 1 of 8");
        touch(user, xr::registration::spreadPlaces({User::kStart_m, 0.04}, 8));
        user.press("Done");
    });
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("8 points, 0 left out"));
    const Registration kept = loadRegistration(command_ / "kept.json");
    expectRight(kept, place);
    EXPECT_EQ(kept.key.device, "bridge");
    EXPECT_EQ(kept.key.unit, "emulated Touch");
    EXPECT_FALSE(kept.key.space.empty());
    EXPECT_NEAR(kept.scale, 1.0, 0.002);

    // The next day: one touch says that it still holds. Then somebody pushes the table.
    const Outcome again = run("", place, [&](User& user) {
        user.mustHear("to begin");
        user.press("Point 1 of 1");
        touch(user, {User::kStart_m + Vec3(0.02, 0.01, -0.01)});
        user.press("Done");
    });
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_THAT(again.err, HasSubstr("It holds: The device is still where it was"));
    Place pushed = place;
    pushed.stage_from_device.position_m.x += 0.03;
    const Outcome moved = run("", pushed, [&](User& user) {
        user.mustHear("to begin");
        user.press("Point 1 of 1");
        user.rest(User::kStart_m + Vec3(0.02, 0.01, -0.01));
        user.press("register it anew");
        giveUp(SIGTERM);
    });
    EXPECT_EQ(moved.status, 1) << moved.err;
    EXPECT_THAT(moved.err, HasSubstr("It has moved: The device has moved by about 3"));
    EXPECT_EQ(loadRegistration(command_ / "kept.json").date, kept.date) << "given up, nothing is changed";
}

TEST_F(RegisterRun, InMotionTheClocksAreCompared) {
    const Place place;
    const Outcome outcome = run("--in-motion", place, [&](User& user) {
        user.mustHear("to begin");
        findTip(user);
        user.mustHear("Through the whole space");
        user.rest(User::kStart_m);
        user.press("Go on until the bar is full");
        user.sweep(70.0);
        user.mustHear("to keep it");
        user.press("Done");
    });
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const Registration kept = loadRegistration(command_ / "kept.json");
    expectRight(kept, place);
    EXPECT_GT(kept.points, 200);
    EXPECT_LT(std::fabs(kept.latency_s), 0.1);
}

TEST_F(RegisterRun, WhatIsMissingIsSaid) {
    EXPECT_EQ(command_.run("register").status, 106) << "--device is required";
    EXPECT_THAT(command_.run("register --device joystick").err, HasSubstr("not among"));
    EXPECT_THAT(command_.run("register --device replay").err, HasSubstr("--trace"));
    std::ofstream(command_ / "hand.csv") << "t_ns,x_m,y_m,z_m,qw,qx,qy,qz,buttons\n0,0,0,0,1,0,0,0,0\n";
    const std::string replay = "register --device replay --trace '" + (command_ / "hand.csv").string() + "'";
    command_.set("XR_RUNTIME_JSON", (command_ / "nowhere.json").string());
    const Outcome alone = command_.run(replay);
    EXPECT_EQ(alone.status, 2);
    EXPECT_THAT(alone.err, HasSubstr("stylet: register: headset: "));
    EXPECT_FALSE(std::filesystem::exists(command_.out()));
}

TEST_F(RegisterRun, ATerminationInTheMiddleKeepsNothing) {
    for (const bool further : {false, true}) {
        const Outcome outcome = run("", {}, [&](User& user) {
            user.mustHear("to begin");
            if (further) user.press("Press the trigger, then turn");
            giveUp(SIGTERM);
        });
        EXPECT_EQ(outcome.status, 1) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(command_ / "kept.json"));
    }
}

// HZ-FORCE-13
TEST_F(RegisterRun, AMovedRoomBeginsAnewAndALostHeadsetKeepsNothing) {
    const Outcome outcome = run("", {}, [&](User& user) {
        user.mustHear("to begin");
        user.press("Press the trigger, then turn");
        user.mock().ask({{"apply", {{"events", json::array({{{"recenter", {{"space", "stage"}}}}})}}}});
        user.mustHear("the room was moved by the runtime: from the beginning");
        user.mustHear("to begin");
        user.mock().ask(
            {{"apply", {{"events", json::array({{{"session_loss", {{"lost_after_s", 0.5}}}}})}}}});
    });
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("the headset was lost"));
    EXPECT_FALSE(std::filesystem::exists(command_ / "kept.json"));
}

}  // namespace
}  // namespace stylet::trainer
