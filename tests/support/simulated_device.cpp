// The linear part is integrated by the trapezoidal rule, which neither damps nor excites an oscillation and
// is stable at any step size. Coulomb friction follows as an implicit step, so that a stuck device stays at
// rest.
#include "tests/support/simulated_device.h"

#include <algorithm>
#include <cmath>

namespace stylet::test {

using namespace haptics;

namespace {

constexpr double kStep_s = 1e-4;
// Worst values of the Phantom class, see profiles.cpp.
constexpr double kMinDamping_n_s_per_m = 0.005, kCoarsest_m = 55e-6;

// Returns a pseudo-random number in [0, 1) (SplitMix64; Steele, Lea, Flood 2014).
double draw(std::uint64_t seed, std::uint64_t index) noexcept {
    std::uint64_t z = seed + (index + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return double((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

double length(const Vec3& v) noexcept {
    return std::sqrt(glm::dot(v, v));
}

}  // namespace

SimulatedBody makeSimulatedBody(const DeviceProfile& p, const HandModel& hand) noexcept {
    SimulatedBody body;
    body.mass_kg = valueOrDefault(p.mass_kg, kLightestMass_kg);
    body.damping_n_s_per_m = valueOrDefault(p.damping_n_s_per_m, kMinDamping_n_s_per_m);
    body.friction_n = valueOrDefault(p.friction_n, 0.0);
    body.resolution_m = valueOrDefault(p.resolution_m, kCoarsest_m);
    body.delay_s = p.delay_s;
    body.hand = hand;
    return body;
}

SimulatedDevice::SimulatedDevice(const Trace& wanted, const DeviceProfile& profile, const SimulatedBody& body)
    : wanted_(&wanted), profile_(profile), body_(body) {}

DeviceState SimulatedDevice::read(std::int64_t now_ns) noexcept {
    double now_s = double(now_ns) * 1e-9;
    if (body_.jitter_s > 0.0) now_s += body_.jitter_s * draw(body_.seed, draws_++);
    if (!begun_) begin(now_s);
    advance(now_s);
    const TraceSample wanted = sampleAt(*wanted_, now_ns, cursor_);
    DeviceState read;
    read.device_from_stylus = {wanted.device_from_stylus.rotation, state_.position_m};
    read.buttons = wanted.buttons;
    if (body_.resolution_m > 0.0) {
        Vec3& p = read.device_from_stylus.position_m;
        for (int k = 0; k < 3; ++k)
            p[k] = std::floor(p[k] / body_.resolution_m + 0.5) * body_.resolution_m;
    }
    return read;
}

void SimulatedDevice::send(const Vec3& force_n) noexcept {
    if (waiting_count_ == kMaxWaiting) {  // the queue is full: the oldest force takes effect early
        state_.motor_n = waiting_[std::size_t(first_)].force_n;
        first_ = (first_ + 1) % kMaxWaiting;
        --waiting_count_;
    }
    waiting_[std::size_t((first_ + waiting_count_++) % kMaxWaiting)] = {state_.time_s + body_.delay_s,
                                                                        force_n};
}

void SimulatedDevice::begin(double now_s) noexcept {
    const TraceSample wanted = sampleAt(*wanted_, std::llround(now_s * 1e9), cursor_);
    state_.position_m = target_m_ = wanted.device_from_stylus.position_m;
    state_.velocity_m_per_s = body_.velocity_m_per_s;
    state_.time_s = target_time_s_ = now_s;
    begun_ = true;
}

// Simulates up to `to_s`. Each queued force takes effect at its time.
void SimulatedDevice::advance(double to_s) noexcept {
    if (to_s <= state_.time_s) return;
    const Vec3 target = sampleAt(*wanted_, std::llround(to_s * 1e9), cursor_).device_from_stylus.position_m;
    const Vec3 target_velocity = (target - target_m_) / (to_s - target_time_s_);
    while (waiting_count_ > 0 && waiting_[std::size_t(first_)].at_s < to_s) {
        const Waiting& next = waiting_[std::size_t(first_)];
        integrate(next.at_s, target_m_ + (next.at_s - target_time_s_) * target_velocity, target_velocity);
        state_.motor_n = next.force_n;
        first_ = (first_ + 1) % kMaxWaiting;
        --waiting_count_;
    }
    integrate(to_s, target, target_velocity);
    target_m_ = target;
    target_time_s_ = to_s;
}

// Simulates up to `to_s` under a constant motor force. `target_m` is the target position at `to_s`.
void SimulatedDevice::integrate(double to_s, const Vec3& target_m, const Vec3& target_velocity) noexcept {
    const double duration_s = to_s - state_.time_s;
    if (duration_s <= 0.0) return;
    const int steps = int(std::ceil(duration_s / kStep_s));
    const double h = duration_s / steps;
    for (int i = 0; i < steps; ++i)
        step(h, target_m - (double(steps - i) - 0.5) * h * target_velocity, target_velocity);
    state_.time_s = to_s;
}

// `target_m` and `target_velocity` are the values at the middle of the step.
void SimulatedDevice::step(double h, const Vec3& target_m, const Vec3& target_velocity) noexcept {
    const HandModel& hand = state_.time_s < body_.release_s ? body_.hand : kNoHand;
    const double mass = body_.mass_kg + hand.mass_kg;
    const double damping = body_.damping_n_s_per_m + hand.damping_n_s_per_m;
    const double stiffness = hand.stiffness_n_per_m;
    const double implicit = 0.5 * h * damping / mass + 0.25 * h * h * stiffness / mass;
    const Vec3 before = state_.velocity_m_per_s;
    const Vec3 driven = state_.motor_n + body_.weight_n + stiffness * (target_m - state_.position_m) +
                        hand.damping_n_s_per_m * target_velocity;
    const Vec3 free = ((1.0 - implicit) * before + (h / mass) * driven) / (1.0 + implicit);
    const double speed = length(free), brake = h * body_.friction_n / (mass * (1.0 + implicit));
    const Vec3 after = speed > brake ? free * (1.0 - brake / speed) : Vec3(0.0);

    const Vec3 mean = 0.5 * (before + after), moved = h * mean;
    const Vec3 rubbed_n_s = mass * (1.0 + implicit) * (free - after);
    state_.position_m += moved;
    state_.velocity_m_per_s = after;
    state_.motor_work_j += glm::dot(state_.motor_n, moved);
    state_.motor_impulse_n_s += h * state_.motor_n;
    state_.dissipated_j += body_.damping_n_s_per_m * glm::dot(mean, moved) + glm::dot(rubbed_n_s, mean);
}

}  // namespace stylet::test
