#include "app/trainer/hands/snap.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include "app/trainer/attempt/tool_pose.h"
#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/window_port.h"

namespace stylet::trainer {

using haptics::TickOutput;
using haptics::Tool;

namespace {

constexpr double kSnapReach_m = 0.25, kSample_m = 0.0005;
constexpr double kInSkin_m = 0.003;                               // a tool deeper than this is in the body
constexpr double kSharpAbove_m = 0.003, kProbePressed_m = 0.001;  // of scalpel and needle; of the probe
constexpr double kContact_n = 0.02;

// The first point of the body along a ray that begins outside it.
std::optional<Vec3> firstSkin(const TickOutput& now, const patient::Patient& patient, const Vec3& from_m,
                              const Vec3& direction) {
    const patient::MotionModel& motion = patient.package().motion;
    for (double at_m = 0.0; at_m <= kSnapReach_m; at_m += kSample_m) {
        const Vec3 p_m = from_m + at_m * direction;
        const Vec3 reference_m =
            patient::referenceFromDeformed(motion, now.breath, patient::Side::outside, p_m);
        if (patient.at(reference_m, {true, false}).tissue != patient::Tissue::air) return p_m;
    }
    return std::nullopt;
}

haptics::TouchPoint skinAt(const TickOutput& now, const patient::Patient& patient,
                           const haptics::TouchMap& touch, const Vec3& at_m) {
    return haptics::touchAt(touch, patient::referenceFromDeformed(patient.package().motion, now.breath,
                                                                  patient::Side::outside, at_m));
}

std::string whyNot(const training::DifficultyRules& rules, const TickOutput& now) {
    if (!rules.snap) return "this difficulty does not place tools: move the tool to the skin";
    if (haptics::isAccessTool(now.tool)) return "wire, dilator and drain stay on their track";
    if (haptics::isNeedleTool(now.tool) && now.phase != haptics::Phase::outside)
        return "the needle is in the body: draw it out first";
    if (now.tool == Tool::scalpel && now.cut_incision >= 0)
        return "the scalpel is in the skin: lift it first";
    return "";
}

}  // namespace

std::optional<Pose> poseOnSkin(const training::DifficultyRules& rules, const TickOutput& now,
                               const patient::Patient& patient, const haptics::TouchMap& touch,
                               std::string& why_not) {
    why_not = whyNot(rules, now);
    if (!why_not.empty()) return std::nullopt;
    const Pose& tool = now.patient_from_tool;
    const Vec3 out = tool.direction({0.0, 0.0, 1.0}), down{0.0, -1.0, 0.0};
    if (skinAt(now, patient, touch, tool.position_m).level_m < -kInSkin_m) {
        why_not = "the tool is in the body: draw it out first";
        return std::nullopt;
    }
    std::optional<Vec3> skin_m = firstSkin(now, patient, tool.position_m, -out);
    if (!skin_m) skin_m = firstSkin(now, patient, tool.position_m, down);
    if (!skin_m) {
        why_not = "there is no skin beneath the tool";
        return std::nullopt;
    }
    const Vec3 slope = skinAt(now, patient, touch, *skin_m).level_slope;
    const Vec3 normal = glm::length(slope) > 0.1 ? glm::normalize(slope) : -down;
    const bool sharp = now.tool == Tool::scalpel || haptics::isNeedleTool(now.tool);
    const double above_m = sharp ? kSharpAbove_m : now.tool == Tool::probe ? -kProbePressed_m : 0.0;
    const Quat rotation = haptics::isNeedleTool(now.tool)
                              ? tool.rotation
                              : glm::normalize(rotationBetween(out, normal) * tool.rotation);
    return Pose{rotation, *skin_m + above_m * normal};
}

std::string requestSnap(const Pose& driver_from_tool, ControllerPort* controller, WindowPort& mouse) {
    if (controller) {
        controller->snapTo(driver_from_tool);
        return "";
    }
    return mouse.snapTo(driver_from_tool) ? "" : "earlier requests are still waiting: try again in a moment";
}

bool touchesPatient(const TickOutput& now) noexcept {
    const Vec3& force_n = now.tool_force.force_n;
    return now.phase != haptics::Phase::outside || now.cut_incision >= 0 || haptics::isAccessTool(now.tool) ||
           now.probe_touching_share > 0.0 || glm::dot(force_n, force_n) > kContact_n * kContact_n;
}

void SnapOffset::aim(const Pose& hand, const Pose& goal) noexcept {
    wanted_m_ = goal.position_m - hand.position_m;
    wanted_turn_ = glm::normalize(goal.rotation * glm::conjugate(hand.rotation));
}

void SnapOffset::release() noexcept {
    wanted_m_ = Vec3(0.0);
    wanted_turn_ = {1.0, 0.0, 0.0, 0.0};
}

void SnapOffset::step(double dt_s) noexcept {
    const Vec3 left_m = wanted_m_ - shift_m_;
    const double length_m = std::sqrt(glm::dot(left_m, left_m)), most_m = kSpeed_m_s * dt_s;
    shift_m_ += length_m > most_m ? left_m * (most_m / length_m) : left_m;
    const double cosine = std::min(1.0, std::fabs(glm::dot(turn_, wanted_turn_)));
    const double angle_rad = 2.0 * std::acos(cosine);
    turn_ = angle_rad > kTurn_rad_s * dt_s
                ? glm::normalize(glm::slerp(turn_, wanted_turn_, kTurn_rad_s * dt_s / angle_rad))
                : wanted_turn_;
}

Pose SnapOffset::apply(const Pose& hand) const noexcept {
    return {glm::normalize(turn_ * hand.rotation), hand.position_m + shift_m_};
}

}  // namespace stylet::trainer
