#include "app/trainer/hands/controller_hand.h"

#include <glm/geometric.hpp>
#include <utility>

namespace stylet::trainer {

using haptics::DeviceStage;
using haptics::DeviceState;
using haptics::Phase;
using haptics::TickOutput;

namespace {

// The tool's tip lies 15 cm in front of the fist, which keeps the fist clear of the skin. The tool points
// along OpenXR's aim pose.
constexpr Pose kAimFromTool{{1.0, 0.0, 0.0, 0.0}, {0.0, 0.0, -0.15}};
constexpr float kSqueezed = 0.5f, kPushed = 0.7f;
constexpr Vibration kTouch{0.25f, 15'000'000}, kCut{0.8f, 35'000'000};
constexpr double kTouching_n = 0.02;

bool touches(const TickOutput& tick) {
    return tick.phase != Phase::outside || tick.probe_touching_share > 0.0 ||
           glm::dot(tick.tool_force.force_n, tick.tool_force.force_n) > kTouching_n * kTouching_n;
}

// True if a border was punctured, other tissue was entered, or the scalpel began to cut.
bool cutBetween(const TickOutput& a, const TickOutput& b) {
    if (b.incision_count > a.incision_count) return true;
    if (!haptics::isNeedleTool(b.tool) || b.phase == Phase::outside || b.depth_m < a.depth_m) return false;
    return (a.phase == Phase::tenting && b.phase != Phase::tenting) ||
           (a.phase != Phase::outside && a.tissue != b.tissue);
}

}  // namespace

void ControllerPort::attach(GripAt grip_at) {
    const std::scoped_lock lock(grip_mutex_, mutex_);
    grip_at_ = std::move(grip_at);
    frame_.buttons = 0;
    frame_.thumbstick = {0.0f, 0.0f};
}

void ControllerPort::publish(const Frame& frame) {
    const std::lock_guard lock(mutex_);
    const std::optional<Pose> last_aim = frame_.grip_from_aim;
    frame_ = frame;
    if (!frame_.grip_from_aim) frame_.grip_from_aim = last_aim;
}

ControllerPort::Frame ControllerPort::frame() {
    const std::lock_guard lock(mutex_);
    return frame_;
}

std::optional<Vibration> ControllerPort::popVibration() {
    const std::lock_guard lock(mutex_);
    return std::exchange(vibration_, std::nullopt);
}

std::optional<Pose> ControllerPort::toolAt(std::int64_t when_ns, std::uint32_t& buttons) {
    const std::lock_guard asked(grip_mutex_);
    const std::optional<Pose> stage_from_grip = grip_at_ ? grip_at_(when_ns) : std::nullopt;
    if (!stage_from_grip) return std::nullopt;
    const std::lock_guard lock(mutex_);
    buttons = frame_.buttons;
    return frame_.room_from_stage * *stage_from_grip * frame_.grip_from_aim.value_or(Pose{}) * kAimFromTool;
}

std::optional<Pose> ControllerPort::popSnap() {
    const std::lock_guard lock(mutex_);
    return std::exchange(snap_, std::nullopt);
}

void ControllerPort::snapTo(const Pose& room_from_tool) {
    const std::lock_guard lock(mutex_);
    snap_ = room_from_tool;
}

void ControllerPort::vibrate(const Vibration& vibration) {
    const std::lock_guard lock(mutex_);
    vibration_ = vibration;
}

std::uint32_t controllerButtons(const ControllerKeys& tool, const ControllerKeys& other) {
    return (tool.select ? 1u << 0 : 0u) | (tool.menu ? 1u << 1 : 0u) |
           (tool.squeeze > kSqueezed ? 1u << 2 : 0u) | (other.select ? 1u << 3 : 0u) |
           (other.squeeze > kSqueezed ? 1u << 4 : 0u) | (other.menu ? 1u << 5 : 0u) |
           (tool.stick_up > kPushed ? 1u << 6 : 0u);
}

haptics::DeviceProfile controllerProfile() noexcept {
    haptics::DeviceProfile p =
        haptics::inputOnlyProfile("controller", "input only: it vibrates, and pushes nothing");
    p.rate_hz = 250.0;
    return p;
}

ControllerDriver::ControllerDriver(ControllerPort& port, ControllerSide side, const haptics::Clock& clock)
    : port_(port),
      missing_(std::string("no controller is tracked in the ") +
               (side == ControllerSide::left ? "left" : "right") +
               " hand: put the headset on, switch the controller on, hold it in sight, close menus and other "
               "programs in front"),
      clock_(clock) {}

DeviceStage ControllerDriver::open(std::string& why) {
    std::uint32_t buttons = 0;
    last_ns_ = now();
    untracked_ns_ = 0;
    if (port_.toolAt(last_ns_, buttons)) return DeviceStage::ready;
    why = missing_;
    return DeviceStage::absent;
}

DeviceStage ControllerDriver::exchange(const Vec3&, DeviceState& state, std::string& why) {
    const std::int64_t now_ns = now();
    const std::int64_t passed_ns = std::clamp<std::int64_t>(now_ns - last_ns_, 0, kMaxStep_ns);
    last_ns_ = now_ns;
    if (const auto tool = port_.toolAt(now_ns, state.buttons)) {
        if (const auto goal = port_.popSnap()) snap_.aim(*tool, *goal);
        if ((state.buttons & kSnapButton) == 0 && !port_.touches()) snap_.release();
        snap_.step(double(passed_ns) * 1e-9);
        state.device_from_stylus = snap_.apply(*tool);
        state.fresh = 1;
        untracked_ns_ = 0;
    } else if ((untracked_ns_ += passed_ns) > kLostAfter_ns) {
        why = missing_;
        return DeviceStage::absent;
    }
    return DeviceStage::ready;
}

std::optional<Vibration> Vibrations::update(const TickOutput& newest) {
    const std::optional<TickOutput> before = std::exchange(last_, newest);
    if (!before || before->tool != newest.tool) return std::nullopt;
    if (cutBetween(*before, newest)) return kCut;
    if (!touches(*before) && touches(newest)) return kTouch;
    return std::nullopt;
}

}  // namespace stylet::trainer
