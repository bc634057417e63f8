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

// Returns nullopt if the hand is not visible, the base space cannot be located, or the session has no
// focus.
std::optional<Joints> baseFromJoints(const HandTracker& tracker, const Space& base, std::int64_t time_ns) {
    const Session& session = tracker.session;
    if (session.progress.state != XR_SESSION_STATE_FOCUSED) return std::nullopt;
    const std::optional<Pose> stage_from_base = stageFromSpace(base, time_ns);
    std::optional<Joints> joints = stageFromJoints(makeSources(session), tracker.is_left, time_ns);
    if (!stage_from_base || !joints) return std::nullopt;
    const Pose base_from_stage = inverse(*stage_from_base);
    for (Joint& joint : *joints)
        joint.stage_from_joint = base_from_stage * joint.stage_from_joint;
    return joints;
}

void fillVelocities(const HandTracker& tracker, const Space& base, std::int64_t time_ns,
                    XrHandJointVelocityEXT* velocities) {
    time_ns = std::min(time_ns, std::numeric_limits<std::int64_t>::max() - kStepNs);
    const auto before = baseFromJoints(tracker, base, time_ns - kStepNs);
    const auto after = baseFromJoints(tracker, base, time_ns + kStepNs);
    for (std::size_t i = 0; i < XR_HAND_JOINT_COUNT_EXT; ++i) {
        velocities[i] = {};
        if (!before || !after) continue;
        const Velocity velocity =
            centralDifference((*before)[i].stage_from_joint, (*after)[i].stage_from_joint);
        velocities[i] = {kMoving, toXr(velocity.linear_m_per_s), toXr(velocity.angular_rad_per_s)};
    }
}

}  // namespace

XrResult createHandTracker(Call& call, XrSession handle, const XrHandTrackerCreateInfoEXT* info,
                           XrHandTrackerEXT* out) {
    Session& session = call.live<Session>(handle);
    requireStruct(info, XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT);
    requireValid(out != nullptr, "handTracker is null");
    requireValid(info->hand == XR_HAND_LEFT_EXT || info->hand == XR_HAND_RIGHT_EXT, "hand is no known value");
    requireValid(info->handJointSet == XR_HAND_JOINT_SET_DEFAULT_EXT, "handJointSet is no known value");
    require(session.instance.scenario.hand_tracking, XR_ERROR_FEATURE_UNSUPPORTED,
            "the scenario's system does not track hands");
    auto tracker = std::make_unique<HandTracker>(session, info->hand == XR_HAND_LEFT_EXT);
    *out = toHandle<XrHandTrackerEXT>(call.create(std::move(tracker), &session));
    return XR_SUCCESS;
}

XrResult locateHandJoints(Call& call, XrHandTrackerEXT handle, const XrHandJointsLocateInfoEXT* info,
                          XrHandJointLocationsEXT* locations) {
    const HandTracker& tracker = call.live<HandTracker>(handle);
    requireStruct(info, XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT);
    requireStruct(locations, XR_TYPE_HAND_JOINT_LOCATIONS_EXT);
    const Space& base = call.live<Space>(info->baseSpace);
    requireValid(&base.session == &tracker.session, "baseSpace is of another session");
    requireTime(info->time);
    requireValid(locations->jointCount == XR_HAND_JOINT_COUNT_EXT && locations->jointLocations != nullptr,
                 "there must be 26 joint locations");
    const auto* velocities =
        findInChain<XrHandJointVelocitiesEXT>(locations->next, XR_TYPE_HAND_JOINT_VELOCITIES_EXT);
    requireValid(velocities == nullptr || (velocities->jointCount == XR_HAND_JOINT_COUNT_EXT &&
                                           velocities->jointVelocities != nullptr),
                 "there must be 26 joint velocities");
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
