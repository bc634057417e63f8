// Physical model of a device and the hand on it: a force moves them, and the device reports the motion. It
// replaces hardware in tests and in the stability campaign (tests/bench/stress/stress_case.h, stress_run.h).
//
//   m a = F_motor + w + k (x_want - x) + b_hand (v_want - v) - b_phys v - f_c v/|v|
//
// m is the mass of body and hand, w the unbalanced weight, k and b_hand the hand's spring and damper toward
// the intended motion, b_phys and f_c the device's own damping and friction. The forces move the body's
// position only. Its rotation is always the intended one, because three motors cannot turn the stylus against
// the hand.
#pragma once

#include <array>
#include <limits>

#include "haptics/loop/trace.h"
#include "haptics/tools/device.h"

namespace stylet::test {

using haptics::DeviceProfile;
using haptics::DeviceState;
using haptics::Trace;

// The hand on the grip: it adds mass, and a spring and damper to the intended position.
struct HandModel {
    double mass_kg = 0.0, damping_n_s_per_m = 0.0, stiffness_n_per_m = 0.0;
};
// No hand, and the two ends of the range of hands that are commonly assumed in studies of haptic stability
// (packaging/guide/model.md, section 4).
inline constexpr HandModel kNoHand{}, kLightHand{0.2, 2.0, 100.0}, kFirmHand{0.2, 10.0, 500.0};

struct SimulatedBody {
    double mass_kg = 0.1;  // effective device mass at the tip
    double damping_n_s_per_m = 0.005;
    double friction_n = 0.0;
    double resolution_m = 0.0;  // encoders read whole multiples of it along each axis; 0: exact
    HandModel hand{};
    double release_s = std::numeric_limits<double>::infinity();  // the hand lets go at this time
    double delay_s = 0.0;        // from send() to the motor; at most kMaxWaiting forces may be on the way
    double jitter_s = 0.0;       // reads are late by up to this, uniformly distributed; less than the tick
    Vec3 weight_n{0.0};          // weight that the device does not balance
    Vec3 velocity_m_per_s{0.0};  // initial velocity
    std::uint64_t seed = 0;      // of the jitter
};
// Unknown properties of a device are set to the worst of the Phantom class: lightest, least damped, no
// friction, coarsest encoder.
SimulatedBody makeSimulatedBody(const DeviceProfile&, const HandModel&) noexcept;

// The exact state, before the encoders round it.
struct BodyState {
    double time_s = 0.0;  // jitter included
    Vec3 position_m{0.0}, velocity_m_per_s{0.0};
    Vec3 motor_n{0.0};            // present motor force
    double motor_work_j = 0.0;    // done by the motor since the start
    double dissipated_j = 0.0;    // lost in the device's own damping and friction since the start
    Vec3 motor_impulse_n_s{0.0};  // since the start
};

class SimulatedDevice final : public haptics::HapticDevice {
  public:
    static constexpr int kMaxWaiting = 128;
    // `wanted` is the intended motion of the hand; the body starts on this motion. The trace must outlive the
    // device.
    SimulatedDevice(const Trace& wanted, const DeviceProfile&, const SimulatedBody&);
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override;
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override;
    const BodyState& body() const noexcept { return state_; }

  private:
    struct Waiting {
        double at_s = 0.0;
        Vec3 force_n{0.0};
    };
    void begin(double now_s) noexcept;
    void advance(double to_s) noexcept;
    void integrate(double to_s, const Vec3& target_m, const Vec3& target_velocity_m_per_s) noexcept;
    void step(double h_s, const Vec3& target_m, const Vec3& target_velocity_m_per_s) noexcept;

    const Trace* wanted_;
    DeviceProfile profile_;
    SimulatedBody body_;
    BodyState state_;
    double target_time_s_ = 0.0;
    Vec3 target_m_{0.0};
    bool begun_ = false;
    std::uint64_t draws_ = 0;
    std::size_t cursor_ = 0;
    std::array<Waiting, kMaxWaiting> waiting_{};
    int first_ = 0, waiting_count_ = 0;
};

}  // namespace stylet::test
