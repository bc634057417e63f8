// XR_EXT_hand_tracking.
#include <algorithm>
#include <limits>
#include <memory>

#include "api/api.h"
#include "world/hand_pose.h"
#include "world/objects.h"
#include "world/spaces.h"
#include "world/verify.h"

namespace xrmock {

namespace {

constexpr XrSpaceVelocityFlags kMoving =
    XR_SPACE_VELOCITY_LINEAR_VALID_BIT | XR_SPACE_VELOCITY_ANGULAR_VALID_BIT;

// Returns nullopt if the hand is not visible, the base space cannot be located, or the session has no
// focus.
std::optional<Joints> baseFromJoints(const HandTracker& tracker, const Space& base, std::int64_t time_ns) {
    const Session& session = tracker.session;
    if (session.progress.state != XR_SESSION_STATE_FOCUSED) return std::nullopt;
    const std::optional<Pose> stage_from_base = stageFromSpace(base, time_ns);
    std::optional<Joints> joints = stageFromJoints(sourcesOf(session), tracker.is_left, time_ns);
    if (!stage_from_base || !joints) return std::nullopt;
    const Pose base_from_stage = inverse(*stage_from_base);
    for (Joint& joint : *joints)
        joint.stage_from_joint = base_from_stage * joint.stage_from_joint;
    return joints;
}

void fillVelocities(const HandTracker& tracker, const Space& base, std::int64_t time_ns,
                    XrHandJointVelocityEXT* velocities) {
    constexpr std::int64_t kStepNs = 500'000;  // central difference over 1 ms
    constexpr double kPerSecond = 1e9 / (2.0 * kStepNs);
    time_ns = std::min(time_ns, std::numeric_limits<std::int64_t>::max() - kStepNs);
    const auto before = baseFromJoints(tracker, base, time_ns - kStepNs);
    const auto after = baseFromJoints(tracker, base, time_ns + kStepNs);
    for (std::size_t i = 0; i < XR_HAND_JOINT_COUNT_EXT; ++i) {
        velocities[i] = {};
        if (!before || !after) continue;
        const Pose& from = (*before)[i].stage_from_joint;
        const Pose& to = (*after)[i].stage_from_joint;
        const Vec3 turn = rotationBetween(from, to);
        const auto linear = [&](std::size_t axis) {
            return static_cast<float>((to.position[axis] - from.position[axis]) * kPerSecond);
        };
        const auto angular = [&](std::size_t axis) { return static_cast<float>(turn[axis] * kPerSecond); };
        velocities[i] = {kMoving, {linear(0), linear(1), linear(2)}, {angular(0), angular(1), angular(2)}};
    }
}

}  // namespace

XrResult createHandTracker(Call& call, XrSession handle, const XrHandTrackerCreateInfoEXT* info,
                           XrHandTrackerEXT* out) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT);
    require(out != nullptr, XR_ERROR_VALIDATION_FAILURE, "handTracker is null");
    require(info->hand == XR_HAND_LEFT_EXT || info->hand == XR_HAND_RIGHT_EXT, XR_ERROR_VALIDATION_FAILURE,
            "hand is no known value");
    require(info->handJointSet == XR_HAND_JOINT_SET_DEFAULT_EXT, XR_ERROR_VALIDATION_FAILURE,
            "handJointSet is no known value");
    require(session.instance.scenario.hand_tracking, XR_ERROR_FEATURE_UNSUPPORTED,
            "the scenario's system does not track hands");
    auto tracker = std::make_unique<HandTracker>(session, info->hand == XR_HAND_LEFT_EXT);
    *out = handleOf<XrHandTrackerEXT>(call.create(std::move(tracker), &session));
    return XR_SUCCESS;
}

XrResult destroyHandTracker(Call& call, XrHandTrackerEXT handle) {
    runtime().handles.destroy(call.evenLost<HandTracker>(handle));
    return XR_SUCCESS;
}

XrResult locateHandJoints(Call& call, XrHandTrackerEXT handle, const XrHandJointsLocateInfoEXT* info,
                          XrHandJointLocationsEXT* locations) {
    const HandTracker& tracker = call.live<HandTracker>(handle);
    requireStruct(info, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT);
    requireStruct(locations, XR_TYPE_HAND_JOINT_LOCATIONS_EXT);
    const Space& base = call.live<Space>(info->baseSpace);
    require(&base.session == &tracker.session, XR_ERROR_VALIDATION_FAILURE,
            "baseSpace is of another session");
    requireTime(info->time);
    require(locations->jointCount == XR_HAND_JOINT_COUNT_EXT && locations->jointLocations != nullptr,
            XR_ERROR_VALIDATION_FAILURE, "there must be 26 joint locations");
    const auto* velocities =
        findInChain<XrHandJointVelocitiesEXT>(locations->next, XR_TYPE_HAND_JOINT_VELOCITIES_EXT);
    require(velocities == nullptr ||
                (velocities->jointCount == XR_HAND_JOINT_COUNT_EXT && velocities->jointVelocities != nullptr),
            XR_ERROR_VALIDATION_FAILURE, "there must be 26 joint velocities");
    const std::optional<Joints> joints = baseFromJoints(tracker, base, info->time);
    locations->isActive = joints ? XR_TRUE : XR_FALSE;
    for (std::size_t i = 0; i < XR_HAND_JOINT_COUNT_EXT; ++i) {
        XrHandJointLocationEXT& location = locations->jointLocations[i];
        location = {0, toXr(Pose{}), 0};
        if (!joints) continue;
        const Joint& joint = (*joints)[i];
        location = {kLocated, toXr(joint.stage_from_joint), static_cast<float>(joint.radius_m)};
    }
    if (velocities != nullptr) fillVelocities(tracker, base, info->time, velocities->jointVelocities);
    return XR_SUCCESS;
}

}  // namespace xrmock
