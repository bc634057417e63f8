// Runs `stylet register` as a user does, with an emulated device behind its socket and the mock runtime's
// controller, whose tip is on the device's tip. Compares the stored registration with the true pose of the
// device. Repeats this in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <condition_variable>
#include <fstream>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <mutex>
#include <thread>

#include "app/trainer/setup/register.h"
#include "tests/app/trainer/command.h"
#include "tests/support/bridge_emulator.h"
#include "tests/support/decimal_comma.h"
#include "tests/support/mock_control.h"
#include "tests/support/nap.h"
#include "tests/support/program_output.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

using nlohmann::json;
using test::Command;
using test::MockControl;
using test::Outcome;
using testing::HasSubstr;

constexpr std::chrono::milliseconds kRegisterPatience = std::chrono::seconds(60);

// Pose of the emulated device, and the tip's position in the grip frame of the controller on it.
struct DevicePlace {
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

Quat swung(double t_s, double size) {
    return glm::angleAxis(size * std::sin(2.1 * t_s), Vec3(1, 0, 0)) *
           glm::angleAxis(size * std::sin(3.3 * t_s), Vec3(0, 0, 1));
}

// A user who moves both devices and reads the program's output.
class RegisterUser {
  public:
    RegisterUser(const std::string& control, const std::filesystem::path& said, test::BridgeServer& device,
                 const DevicePlace& place_in)
        : place(place_in), output(said), mock_(control), device_(device) {
        rest(kStart_m);
    }

    // Holds the button until the program prints `until`. Tries again, because the first press may come too
    // early.
    void press(const std::string& until, const std::string& button = "select/click") {
        for (int tries = 0; tries < 3; ++tries) {
            value(button, true);
            const bool heard = output.waitFor(until, std::chrono::seconds(20));
            value(button, false);
            test::sleepMs(250);
            if (heard) return;
        }
        output.require(until);
    }
    void rest(const Vec3& tip_m, const Quat& turn = {1, 0, 0, 0}, const Quat& stylus = {1, 0, 0, 0}) {
        device_.follow([=](std::int64_t) { return stylusAt(tip_m, stylus); });
        apply({{"poses", json::array({jsonOf(place.gripOf(tip_m, turn))})}});
        test::sleepMs(150);
    }
    void apply(const json& right) { mock_.sendRequest({{"apply", {{"controllers", {{"right", right}}}}}}); }
    MockControl& mock() { return mock_; }

    static constexpr Vec3 kStart_m{0.0, 0.0, 0.1};  // centre of the emulated workspace
    DevicePlace place;
    test::ProgramOutput output;

  private:
    void value(const std::string& button, bool down) { apply({{"values", json::array({{{button, down}}})}}); }

    MockControl mock_;
    test::BridgeServer& device_;
};

// Compares the stored registration with the truth, at points of the whole cube.
void expectRight(const Registration& kept, const DevicePlace& place) {
    double squares = 0.0, worst_m = 0.0;
    for (const Vec3& p : xr::registration::chooseTouchPlaces({RegisterUser::kStart_m, 0.04}, 34)) {
        const double off_m = glm::distance(kept.inStage({{}, p}), place.stage_from_device * p);
        squares += off_m * off_m / 34.0;
        worst_m = std::max(worst_m, off_m);
    }
    EXPECT_LE(std::sqrt(squares), kept.tre_mean_m);
    EXPECT_LE(worst_m, kept.tre_worst_m);
    EXPECT_LT(kept.tre_mean_m, 0.0018);
    EXPECT_LT(glm::distance(kept.grip_from_tip_m, place.grip_from_tip_m), 0.001);
}

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

    // Runs the program while `acts` controls the user.
    template <typename Acts>
    Outcome run(const std::string& arguments, const DevicePlace& place, const Acts& acts) {
        const std::string socket = (command_ / "bridge.sock").string();
        test::BridgeServer device(socket, {});
        device.follow([](std::int64_t) { return stylusAt(RegisterUser::kStart_m); });
        std::filesystem::remove(command_ / "stderr");
        std::thread hands([&] {
            try {
                RegisterUser user(control(), command_ / "stderr", device, place);
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
    void giveUp(int signal = SIGINT) { test::signalProgram(command_ / "number", signal); }

    static void touch(RegisterUser& user, const std::vector<Vec3>& places) {
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double t_s = 0.7 * double(i);
            user.rest(places[i], swung(t_s, 0.4), glm::angleAxis(0.3 * std::sin(t_s), Vec3(0, 1, 0)));
            const bool last = i + 1 == places.size();
            user.press(last ? "to keep it" : "Point " + std::to_string(i + 1) + " is recorded");
        }
    }

    Command command_;
};

// Need real time: only then do the program, the runtime and the device's service run at the same time.
using RegisterRunRealTime = RegisterRun;

TEST_F(RegisterRunRealTime, TouchedPointsGiveTheDevicePose) {
#ifdef STYLET_ROUGH
    // Use a locale with a decimal comma. It must not affect the stored numbers.
    const auto country = test::decimalComma(command_ / "locales", STYLET_ROUGH);
    ASSERT_FALSE(country.empty()) << "localedef knows no de_DE: the package locales is missing";
    for (const auto& [name, value] : country)
        command_.set(name, value);
#endif
    const DevicePlace place;
    const Vec3 tip_mm = 1e3 * place.grip_from_tip_m;
    const std::string known_tip = "--points 4 --tip-mm " + std::to_string(tip_mm.x) + " " +
                                  std::to_string(tip_mm.y) + " " + std::to_string(tip_mm.z);
    const Outcome outcome = run(known_tip, place, [&](RegisterUser& user) {
        user.output.require("to begin");
        user.press("Point 1 of 4");
        touch(user, xr::registration::chooseTouchPlaces({RegisterUser::kStart_m, 0.04}, 4));
        user.press("Done");
    });
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("4 points, 0 left out"));
    const Registration kept = loadRegistration(command_ / "kept.json");
    expectRight(kept, place);
    EXPECT_EQ(kept.key.device, "bridge");
    EXPECT_EQ(kept.key.unit, "emulated Touch");
    EXPECT_FALSE(kept.key.space.empty());
    EXPECT_NEAR(kept.scale, 1.0, 0.002);
}

// Virtual time that advances only when the test advances it. One other thread sleeps on it.
class SteppedTime {
  public:
    haptics::Clock clock() {
        return {this, [](void* self) noexcept { return static_cast<SteppedTime*>(self)->now(); },
                [](void* self, std::int64_t t_ns) noexcept { static_cast<SteppedTime*>(self)->sleep(t_ns); }};
    }
    std::int64_t now() {
        const std::lock_guard lock(mutex_);
        return now_ns_;
    }
    // Advances the time in steps, from each wake-up of the other thread to the next.
    void pass(std::int64_t duration_ns) {
        std::unique_lock lock(mutex_);
        const std::int64_t end_ns = now_ns_ + duration_ns;
        while (now_ns_ < end_ns) {
            waitForSleeper(lock);
            now_ns_ = released_ ? end_ns : std::min(end_ns, wake_ns_);
            changed_.notify_all();
        }
        waitForSleeper(lock);
    }
    // After this call the other thread's sleeps return immediately, so that it can end.
    void release() {
        const std::lock_guard lock(mutex_);
        released_ = true;
        changed_.notify_all();
    }

  private:
    void waitForSleeper(std::unique_lock<std::mutex>& lock) {
        changed_.wait_for(lock, kRegisterPatience, [&] { return released_ || wake_ns_ > now_ns_; });
    }
    void sleep(std::int64_t t_ns) {
        std::unique_lock lock(mutex_);
        wake_ns_ = t_ns;
        changed_.notify_all();
        if (released_)
            changed_.wait_for(lock, std::chrono::milliseconds(1));
        else
            changed_.wait(lock, [&] { return released_ || now_ns_ >= t_ns; });
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::int64_t now_ns_ = 1'000'000'000, wake_ns_ = 0;
    bool released_ = false;
};

// Motion of the user's hands from `begin_s` on, as functions of the time since `begin_s`.
struct RegisterAct {
    double begin_s = 0.0;
    bool press = false;  // presses the trigger at the start
    std::function<Vec3(double t_s)> tipAt;
    std::function<Quat(double t_s)> turnAt, stylusAt;
};

// Registers in virtual time. The acts define the device's and the controller's motion.
class RegisterVirtual : public testing::Test {
  protected:
    struct Played {
        bool stored = false;
        std::string out, err;
    };
    // The device's poses are delayed by this time relative to the controller's.
    static constexpr double kDeviceLag_s = 0.015;

    class Device : public haptics::HapticDevice {
      public:
        explicit Device(const RegisterVirtual& user) : user_(user) {}
        const haptics::DeviceProfile& profile() const noexcept override { return profile_; }
        haptics::DeviceState read(std::int64_t now_ns) noexcept override {
            haptics::DeviceState state;
            const auto [act, t_s] = user_.actAt(1e-9 * double(now_ns) - kDeviceLag_s);
            state.device_from_stylus = {act.stylusAt(t_s), act.tipAt(t_s)};
            return state;
        }
        void send(const Vec3&) noexcept override {}

      private:
        const RegisterVirtual& user_;
        const haptics::DeviceProfile profile_{.name = "emulated Touch"};
    };

    RegisterVirtual() {
        options_.device = "bridge";
        options_.out = folder_ / "kept.json";
    }
    void act(double seconds, bool press, const Vec3& tip_m, const Quat& turn = {1, 0, 0, 0},
             const Quat& stylus = {1, 0, 0, 0}) {
        act(
            seconds, press, [=](double) { return tip_m; }, [=](double) { return turn; },
            [=](double) { return stylus; });
    }
    void act(double seconds, bool press, std::function<Vec3(double)> tipAt,
             std::function<Quat(double)> turnAt, std::function<Quat(double)> stylusAt) {
        acts_.push_back({end_s_, press, std::move(tipAt), std::move(turnAt), std::move(stylusAt)});
        end_s_ += seconds;
    }
    void begin() {
        acts_.clear();
        end_s_ = 0.0;
        act(0.5, false, RegisterUser::kStart_m);
        act(0.5, true, RegisterUser::kStart_m);
    }
    // The tip rests while the controller turns about it, so that the program can find the tip.
    void findTip() {
        act(
            8.0, true, [](double) { return RegisterUser::kStart_m; },
            [](double t_s) { return swung(t_s, 0.6); }, [](double) { return Quat{1, 0, 0, 0}; });
    }
    void touch(const std::vector<Vec3>& places) {
        for (std::size_t i = 0; i < places.size(); ++i) {
            const double t_s = 0.7 * double(i);
            const Quat turn = swung(t_s, 0.4), stylus = glm::angleAxis(0.3 * std::sin(t_s), Vec3(0, 1, 0));
            act(0.2, false, places[i], turn, stylus);
            act(0.8, true, places[i], turn, stylus);
        }
    }
    // Moves device and controller together through the whole workspace.
    void sweep(double seconds) {
        act(
            seconds, true,
            [](double t_s) {
                return RegisterUser::kStart_m +
                       0.04 * std::min(1.0, 0.5 * t_s) *
                           Vec3(std::sin(1.1 * t_s), std::sin(1.7 * t_s), std::sin(2.3 * t_s));
            },
            [](double t_s) { return swung(t_s, 0.5); },
            [](double t_s) { return glm::angleAxis(0.4 * std::sin(0.9 * t_s), Vec3(0, 1, 0)); });
    }
    // Presses the trigger. The program waits for 1.5 s after the last press.
    void press() { act(3.0, true, RegisterUser::kStart_m); }

    // Plays all acts, after which the runtime ends the session. The last act is not recorded.
    Played play(const DevicePlace& place) {
        SteppedTime time;
        begun_s_ = 1e-9 * double(time.now());
        Device device(*this);
        RegisterView view;
        view.frame = [&](const RegisterFrame& shown) {
            RegisterInput answer;
            answer.seen = true;
            if (shown.rgba == nullptr) return answer;
            time.pass(11'000'000);
            const double now_s = 1e-9 * double(time.now());
            const auto [act, t_s] = actAt(now_s);
            answer.select = act.press && t_s < 0.1;
            answer.over = now_s - begun_s_ > end_s_;
            if (&act == &acts_.back() && t_s > 0.1) time.release();
            return answer;
        };
        view.gripAt = [&](std::int64_t now_ns) {
            const auto [act, t_s] = actAt(1e-9 * double(now_ns));
            return std::optional(place.gripOf(act.tipAt(t_s), act.turnAt(t_s)));
        };
        view.space = [] { return std::string("stage"); };
        view.generation = [] { return std::string(); };
        testing::internal::CaptureStdout();
        testing::internal::CaptureStderr();
        Played played;
        played.stored = registerWith(options_, device, view, time.clock());
        std::fflush(stdout);
        played.out = testing::internal::GetCapturedStdout();
        played.err = testing::internal::GetCapturedStderr();
        return played;
    }
    // Returns the act at that time, and the time since it began.
    std::pair<const RegisterAct&, double> actAt(double now_s) const {
        const double t_s = now_s - begun_s_;
        const RegisterAct* found = &acts_.front();
        for (const RegisterAct& each : acts_)
            if (each.begin_s <= t_s) found = &each;
        return {*found, std::max(0.0, t_s - found->begin_s)};
    }

    test::TempFolder folder_;
    RegisterOptions options_;
    std::vector<RegisterAct> acts_;
    double begun_s_ = 0.0, end_s_ = 0.0;
};

TEST_F(RegisterVirtual, TouchedPointsGiveTheDevicePose) {
    const DevicePlace place;
    begin();
    findTip();
    touch(xr::registration::chooseTouchPlaces({RegisterUser::kStart_m, 0.04}, 8));
    press();
    const Played first = play(place);
    ASSERT_TRUE(first.stored) << first.err;
    EXPECT_THAT(first.out, HasSubstr("8 points, 0 left out"));
    for (const char* words : {"to begin", "Press the trigger, then turn", "Keep turning", "Point 1 of 8",
                              "Point 7 is recorded", "to keep it", "Done"})
        EXPECT_THAT(first.err, HasSubstr(words));
    const Registration kept = loadRegistration(options_.out);
    expectRight(kept, place);
    EXPECT_EQ(kept.key.device, "bridge");
    EXPECT_EQ(kept.key.unit, "emulated Touch");
    EXPECT_EQ(kept.key.space, "stage");
    EXPECT_NEAR(kept.scale, 1.0, 0.002);

    // On the next day, one touch confirms the registration. Then somebody pushes the table.
    begin();
    touch({RegisterUser::kStart_m + Vec3(0.02, 0.01, -0.01)});
    press();
    const Played again = play(place);
    EXPECT_TRUE(again.stored) << again.err;
    EXPECT_THAT(again.err, HasSubstr("Point 1 of 1"));
    EXPECT_THAT(again.err, HasSubstr("It holds: The device is still where it was"));
    DevicePlace pushed = place;
    pushed.stage_from_device.position_m.x += 0.03;
    begin();
    touch({RegisterUser::kStart_m + Vec3(0.02, 0.01, -0.01)});
    act(0.5, false, RegisterUser::kStart_m);
    const Played moved = play(pushed);
    EXPECT_FALSE(moved.stored);
    EXPECT_THAT(moved.err, HasSubstr("It has moved: The device has moved by about 3"));
    EXPECT_THAT(moved.err, HasSubstr("register again"));
    EXPECT_EQ(loadRegistration(options_.out).date, kept.date) << "a cancelled registration changes nothing";
}

TEST_F(RegisterVirtual, MotionModeMeasuresTheClockOffset) {
    options_.in_motion = true;
    const DevicePlace place;
    begin();
    findTip();
    sweep(30.0);
    press();
    const Played played = play(place);
    ASSERT_TRUE(played.stored) << played.err;
    EXPECT_THAT(played.err, HasSubstr("Through the whole space"));
    EXPECT_THAT(played.err, HasSubstr("Continue until the bar is full"));
    const Registration kept = loadRegistration(options_.out);
    expectRight(kept, place);
    EXPECT_GT(kept.points, 200);
    EXPECT_NEAR(std::fabs(kept.latency_s), kDeviceLag_s, 0.003);
}

TEST_F(RegisterRun, MissingPartsAreReported) {
    EXPECT_EQ(command_.run("register").status, 100) << "--device is required";
    EXPECT_THAT(command_.run("register --device joystick").err, HasSubstr("not among: replay, falcon"));
    EXPECT_THAT(command_.run("register --device replay").err, HasSubstr("--trace"));
    std::ofstream(command_ / "hand.csv") << "t_ns,x_m,y_m,z_m,qw,qx,qy,qz,buttons\n0,0,0,0,1,0,0,0,0\n";
    const std::string replay = "register --device replay --trace '" + (command_ / "hand.csv").string() + "'";
    command_.set("XR_RUNTIME_JSON", (command_ / "nowhere.json").string());
    const Outcome alone = command_.run(replay);
    EXPECT_EQ(alone.status, 3);
    EXPECT_THAT(alone.err, HasSubstr("stylet: registering a device needs a headset: "));
    EXPECT_FALSE(std::filesystem::exists(command_.out()));
}

TEST_F(RegisterRunRealTime, TerminationSavesNothing) {
    for (const bool further : {false, true}) {
        const Outcome outcome = run("", {}, [&](RegisterUser& user) {
            user.output.require("to begin");
            if (further) user.press("Press the trigger, then turn");
            giveUp(SIGTERM);
        });
        EXPECT_EQ(outcome.status, 1) << outcome.err;
        EXPECT_FALSE(std::filesystem::exists(command_ / "kept.json"));
    }
}

// HZ-FORCE-13
TEST_F(RegisterRunRealTime, MovedSpaceRestartsAndLostHeadsetSavesNothing) {
    const Outcome outcome = run("", {}, [&](RegisterUser& user) {
        user.output.require("to begin");
        user.press("Press the trigger, then turn");
        user.mock().sendRequest(
            {{"apply", {{"events", json::array({{{"recenter", {{"space", "stage"}}}}})}}}});
        user.output.require("the runtime moved the room: starting from the beginning");
        user.output.require("to begin");
        user.mock().sendRequest(
            {{"apply", {{"events", json::array({{{"session_loss", {{"lost_after_s", 0.5}}}}})}}}});
    });
    EXPECT_EQ(outcome.status, 3) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("the headset was lost"));
    EXPECT_FALSE(std::filesystem::exists(command_ / "kept.json"));
}

}  // namespace
}  // namespace stylet::trainer
