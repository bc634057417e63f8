#include "haptics/devices/falcon/calibrate.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/errors.h"
#include "haptics/output/output.h"

namespace stylet::haptics::falcon {

namespace {

constexpr double kForces_n[] = {1.0, 2.0, 3.0};
constexpr double kRise_n_per_s = 1.0;
constexpr double kDt_s = 0.001;
constexpr double kNewtonsPerGram = 9.80665e-3;  // standard gravity
constexpr int kMaxTries = 5;                    // per axis
constexpr double kStartTimeout_s = 10.0;        // for the force to start; its ramp takes 1.5 s

struct Axis {
    int index;
    double down;  // the sign of the force that presses on the scale
    const char* name;
    const char* pose;
};
constexpr Axis kAxes[] = {
    {1, -1.0, "y", "Leave the Falcon upright"},
    {2, 1.0, "z", "Lay the Falcon face down across two stacks of books"},
    {0, -1.0, "x", "Lay the Falcon on its left side"},
};

// Thrown when a fault occurs while the device should be pressing.
struct Faulted {
    std::string text;
};

std::string faultMessage(std::uint32_t bits) {
    for (const FaultText& fault : faultTexts())
        if ((bits & fault.bit) != 0) return fault.text;
    return "the force does not start";
}

// Presses along one axis at a time, at 1 kHz, until the user answers.
class Press {
  public:
    Press(HapticDevice& device, const Clock& clock, const CalibrationPrompts& prompts)
        : device_(device), clock_(clock), prompts_(prompts), next_ns_(clock.now()) {
        settings_.model_force_n = device.profile().force_peak_n;
        // The force is constant, not a spring, so it has no tangent and the gain is one.
        settings_.model_tangent_n_per_m = 1.0;
    }
    Press(const Press&) = delete;
    Press& operator=(const Press&) = delete;
    ~Press() { device_.send(Vec3(0.0)); }

    // Ramps the force to `force_n`, asks the question, and holds the force until there is an answer. Throws
    // Faulted.
    double promptAtForce(const Axis& axis, double force_n, const std::string& question) {
        while (std::fabs(force_n - commanded_n_) > 1e-9)
            tick(axis, commanded_n_ +
                           std::clamp(force_n - commanded_n_, -kRise_n_per_s * kDt_s, kRise_n_per_s * kDt_s));
        for (double waited_s = 0.0; force_n != 0.0 && output_.safety.stage != ForceStage::on;
             waited_s += kDt_s) {
            if (waited_s > kStartTimeout_s) throw Faulted{faultMessage(output_.safety.awaited)};
            tick(axis, force_n);
        }
        prompts_.print(question);
        for (;;) {
            tick(axis, force_n);
            if (const auto answer = prompts_.readNumber()) return *answer;
        }
    }
    // Stops requesting force.
    void release() {
        commanded_n_ = 0.0;
        device_.send(Vec3(0.0));
    }
    double sent_n(const Axis& axis) const { return axis.down * output_.sent_n[axis.index]; }

  private:
    void tick(const Axis& axis, double force_n) {
        commanded_n_ = force_n;
        const DeviceState state = device_.read(t_ns_);
        if (state.fresh != 0) tip_m_ = state.device_from_stylus.position_m;
        OutputTick tick;
        tick.grip_m = tip_m_;
        tick.fault_bits = checkDevice(output_.safety, device_.profile(), state, kDt_s);
        tick.tool.force_n[axis.index] = axis.down * force_n;
        tick.tool.event = true;  // a constant force stores no energy, so there is none to account for
        device_.send(stepOutput(output_, settings_, device_.profile(), 1.0, tick, kDt_s));
        throwOnFault(axis, force_n);
        t_ns_ += 1'000'000;
        // Do not catch up after a late tick: during a burst of ticks the device would appear silent.
        next_ns_ = std::max(next_ns_, clock_.now()) + 1'000'000;
        clock_.sleepUntil(next_ns_);
    }
    void throwOnFault(const Axis& axis, double force_n) {
        if (prompts_.stop()) throw DataError("calibration", axis.name, "stopped");
        if (output_.safety.faults == 0) return;
        const std::string text = faultMessage(output_.safety.faults);
        rearm(output_.safety);  // takes effect once the force is zero
        if (force_n != 0.0) throw Faulted{text};
    }

    HapticDevice& device_;
    Clock clock_;
    const CalibrationPrompts& prompts_;
    OutputSettings settings_;
    OutputState output_;
    Vec3 tip_m_{0.0};
    double commanded_n_ = 0.0;
    std::int64_t t_ns_ = 0, next_ns_;
};

double measure(Press& press, const Axis& axis) {
    const double rest_g = press.promptAtForce(
        axis, 0.0,
        fmt::format("{}. Raise a scale until the grip rests on it in the middle of its reach. How many grams "
                    "does it show?",
                    axis.pose));
    std::vector<CalibrationReading> readings;
    for (const double force_n : kForces_n) {
        const double grams = press.promptAtForce(axis, force_n, "How many grams does the scale show now?");
        readings.push_back({press.sent_n(axis), (grams - rest_g) * kNewtonsPerGram});
    }
    press.promptAtForce(axis, 0.0, "The force is off. Type any number to continue.");
    return fitCalibration(readings, axis.name);
}

}  // namespace

Calibration calibrate(HapticDevice& device, const Clock& clock, const CalibrationPrompts& prompts) {
    Calibration calibration;
    Press press(device, clock, prompts);
    for (const Axis& axis : kAxes)
        for (int tries = 1;; ++tries) {
            try {
                calibration.measured_per_asked[axis.index] = measure(press, axis);
                break;
            } catch (const Faulted& fault) {
                press.release();
                if (tries == kMaxTries)
                    throw EnvironmentError(fmt::format("calibration: {}: {}", axis.name, fault.text));
                prompts.print(fmt::format("The force is off: {}. This axis once more.", fault.text));
            }
        }
    calibration.measured = true;
    calibration.how = "kitchen scale, 1 to 3 N down each axis";
    return calibration;
}

}  // namespace stylet::haptics::falcon
