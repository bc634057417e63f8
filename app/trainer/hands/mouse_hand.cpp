#include "app/trainer/hands/mouse_hand.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/hand.h"
#include "haptics/devices/clutch.h"

namespace stylet::trainer {

using haptics::DeviceStage;
using haptics::DeviceState;

namespace {

constexpr double kBeforeSkin_m = 0.03;
constexpr double kTurn_rad_s = 1.5, kTurnRate_per_s = 12.0;
// Longest time simulated in one exchange, so that the tool does not jump after a suspension of the thread.
constexpr double kMaxStep_s = 0.02, kStep_s = 0.001;

Quat turnedBy(const Vec3& rad, const Quat& from) noexcept {
    const double angle = std::sqrt(glm::dot(rad, rad));
    if (!(angle > 1e-12)) return from;
    const Vec3 axis = rad * (std::sin(0.5 * angle) / angle);
    return glm::normalize(Quat{std::cos(0.5 * angle), axis.x, axis.y, axis.z} * from);
}

}  // namespace

haptics::DeviceProfile mouseProfile() noexcept {
    return haptics::inputOnlyProfile("mouse", "input only: it pushes nothing");
}

Pose mouseStart(const patient::PlannedPath& path) {
    const Vec3 axis = glm::normalize(path.target_m - path.entry_m);
    return needlePose(path.entry_m - kBeforeSkin_m * axis, axis);
}

void SmoothPoint::step(const Vec3& wanted_m, double dt_s) noexcept {
    Vec3 step_m = wanted_m - at_m;
    const double length_m = std::sqrt(glm::dot(step_m, step_m)), most_m = 2.0 * kSpeed_m_s / kRate_per_s;
    if (length_m > most_m) step_m *= most_m / length_m;
    velocity_m_s += dt_s * kRate_per_s * (kRate_per_s * step_m - 2.0 * velocity_m_s);
    at_m += dt_s * velocity_m_s;
}

MouseDriver::MouseDriver(WindowPort& port, const Pose& start, const haptics::GuideSettings& guide,
                         const haptics::Clock& clock)
    : port_(port),
      start_(start),
      wanted_(start),
      guide_(guide),
      clock_(clock),
      point_{start.position_m, Vec3(0.0)},
      turned_(start.rotation),
      held_(toolPoseFromNeedle({}, port.inHand(), guide)) {}

DeviceStage MouseDriver::open(std::string&) {
    last_ns_ = clock_.now_ns(clock_.context);
    return DeviceStage::ready;
}

void MouseDriver::apply(const MouseMove& move) noexcept {
    if (move.home) wanted_ = start_;
    wanted_.rotation = turnedBy(move.turned_rad, wanted_.rotation);
    wanted_.rotation = turnedBy(wanted_.rotation * Vec3(0.0, 0.0, move.rolled_rad), wanted_.rotation);
    const Vec3 deeper = turned_ * Vec3(0.0, 0.0, -1.0);
    wanted_.position_m += move.moved_m + move.deeper_m * deeper;
    const Vec3 step_m = wanted_.position_m - point_.at_m;
    const double length_m = std::sqrt(glm::dot(step_m, step_m));
    if (!move.home && length_m > kLead_m) wanted_.position_m = point_.at_m + step_m * (kLead_m / length_m);
}

void MouseDriver::step(double dt_s) noexcept {
    if (port_.pressing_n() > kMaxPress_n) {
        const Vec3 deeper = turned_ * Vec3(0.0, 0.0, -1.0);
        const double further_m = glm::dot(wanted_.position_m - point_.at_m, deeper);
        if (further_m > 0.0) wanted_.position_m -= further_m * deeper;
    }
    point_.step(wanted_.position_m, dt_s);
    const double cosine = std::min(1.0, std::fabs(glm::dot(turned_, wanted_.rotation)));
    const double angle_rad = 2.0 * std::acos(cosine);
    if (angle_rad > 1e-9) {
        const double share =
            std::min(1.0 - std::exp(-kTurnRate_per_s * dt_s), kTurn_rad_s * dt_s / angle_rad);
        turned_ = glm::normalize(glm::slerp(turned_, wanted_.rotation, share));
    }
    held_ = haptics::moveToward(held_, toolPoseFromNeedle({}, port_.inHand(), guide_), dt_s);
}

DeviceStage MouseDriver::exchange(const Vec3&, DeviceState& state, std::string&) {
    for (MouseMove move; port_.popMove(move);)
        apply(move);
    const std::int64_t now_ns = clock_.now_ns(clock_.context);
    double left_s = std::clamp(double(now_ns - last_ns_) * 1e-9, 0.0, kMaxStep_s);
    last_ns_ = now_ns;
    for (; left_s > 0.0; left_s -= kStep_s)
        step(std::min(left_s, kStep_s));
    state.device_from_stylus = Pose{turned_, point_.at_m} * held_;
    state.fresh = 1;
    return DeviceStage::ready;
}

}  // namespace stylet::trainer
