#include "tests/support/bridge_simulated.h"

#include <chrono>
#include <cmath>
#include <numbers>

namespace stylet::test {

using namespace haptics;
using namespace haptics::bridge;

bool SimulatedSdk::open(Capabilities& capabilities, std::string& why) {
    if (missing.load()) {
        why = "no device is plugged in";
        return false;
    }
    DeviceProfile& p = capabilities.profile;
    p.force_peak_n = 3.3;
    p.force_continuous_n = 0.88;
    p.stiffness_n_per_m = 400.0;
    p.workspace_centre_m = {0.0, 0.0, 0.1};
    p.workspace_radius_m = 0.08;
    putText(capabilities.name, "simulated Touch");
    putText(capabilities.source, "OpenHaptics data sheet: Touch");
    return true;
}

bool SimulatedSdk::start(Servo& servo, std::string&) {
    servo_ = &servo;
    running_.store(true);
    if (threaded_) thread_ = std::thread([this] { run(); });
    return true;
}

void SimulatedSdk::stop() noexcept {
    running_.store(false);
    if (thread_.joinable()) thread_.join();
    motor_n_.store(0.0);
}

bool SimulatedSdk::tick(std::int64_t now_ns) {
    const double angle = 2.0 * std::numbers::pi * 1e-9 * double(now_ns % 1'000'000'000);
    Sample sample;
    sample.sampled_ns = now_ns;
    sample.device_from_stylus.position_m = {0.02 * std::cos(angle), 0.02 * std::sin(angle), 0.1};
    const double motor_n = glm::length(servo_->tick(sample, 3.3));
    if (motor_n > 0.0) last_force_ns_.store(now_ns);
    motor_n_.store(motor_n);
    ticks_.fetch_add(1);
    if (!unplugged_.load()) return true;
    motor_n_.store(0.0);
    servo_->fail("the device was unplugged");
    return false;
}

void SimulatedSdk::run() {
    auto due = std::chrono::steady_clock::now();
    while (running_.load() && tick(monotonic_ns())) {
        due += std::chrono::milliseconds(1);
        std::this_thread::sleep_until(due);
    }
}

}  // namespace stylet::test
