#include "app/trainer/hands/mouse_hand.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/random.h"
#include "app/trainer/attempt/tool_pose.h"
#include "haptics/devices/clutch.h"

namespace stylet::trainer {

using haptics::DeviceStage;
using haptics::DeviceState;

namespace {

constexpr double kBeforeSkin_m = 0.03;
// Start in the room: height above the skin, largest lean, and how the place is searched.
constexpr double kStartLow_m = 0.06, kStartHigh_m = 0.12, kStartLean = 0.4, kStartSample_m = 0.002;
constexpr int kStartTries = 100;
constexpr std::uint64_t kStartStream = 0x5374617274;
constexpr double kTurn_rad_s = 1.5, kTurnRate_per_s = 12.0;
// Longest time simulated in one exchange, so that the tool does not jump after a suspension of the thread.
constexpr double kMaxStep_s = 0.02, kStep_s = 0.001;

// A place above the middle of the trunk, drawn until there is body below it. Patient axes: +x right, +y
// front, +z head.
Pose startInRoom(const patient::Patient& patient, std::uint64_t seed) {
    Random random{seed ^ kStartStream};
    const Grid& grid = patient.package().ct.grid;
    const Vec3 low_m = grid.centre({0, 0, 0}), high_m = grid.centre(grid.dims - 1);
    Vec3 tip_m = 0.5 * (low_m + high_m);
    bool above_body = false;
    for (int tries = 0; tries < kStartTries && !above_body; ++tries) {
        const double right = random.between(0.5, 0.9), headward = random.between(0.25, 0.75);
        tip_m = glm::mix(low_m, high_m, Vec3(right, 1.0, headward));
        while (!above_body && tip_m.y > low_m.y) {
            above_body = patient.at(tip_m, {true, false}).tissue != patient::Tissue::air;
            tip_m.y -= kStartSample_m;
        }
    }
    if (!above_body) tip_m.y = high_m.y;
    tip_m.y += random.between(kStartLow_m, kStartHigh_m);
    const double lean_right = random.between(-kStartLean, kStartLean);
    const double lean_headward = random.between(-kStartLean, kStartLean);
    return needlePose(tip_m, glm::normalize(Vec3(lean_right, -1.0, lean_headward)));
}

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

Pose mouseStart(training::StartPlace place, const patient::Patient& patient, const patient::PlannedPath& path,
                std::uint64_t seed) {
    if (place == training::StartPlace::room) return startInRoom(patient, seed);
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
      tool_pose_(toolPoseFromNeedle({}, port.inHand(), guide)) {}

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
    tool_pose_ = haptics::moveToward(tool_pose_, toolPoseFromNeedle({}, port_.inHand(), guide_), dt_s);
}

DeviceStage MouseDriver::exchange(const Vec3&, DeviceState& state, std::string&) {
    for (MouseMove move; port_.popMove(move);)
        apply(move);
    for (Pose snap; port_.popSnap(snap);)
        wanted_ = snap * toolPoseFromNeedle({}, port_.inHand(), guide_).inverse();
    const std::int64_t now_ns = clock_.now_ns(clock_.context);
    double left_s = std::clamp(double(now_ns - last_ns_) * 1e-9, 0.0, kMaxStep_s);
    last_ns_ = now_ns;
    for (; left_s > 0.0; left_s -= kStep_s)
        step(std::min(left_s, kStep_s));
    state.device_from_stylus = Pose{turned_, point_.at_m} * tool_pose_;
    state.fresh = 1;
    return DeviceStage::ready;
}

}  // namespace stylet::trainer
