#include "xr/hands.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stylet::xr {
namespace {

double distance_m(const std::optional<Pose>& a, const std::optional<Pose>& b) {
    if (!a || !b) return std::numeric_limits<double>::infinity();
    return glm::distance(a->position_m, b->position_m);
}

}  // namespace

// Palm joint: +y points out of the back of the hand, -z along the fingers. Grip: -z points from the little
// finger to the thumb, +x out of the left palm or into the right palm.
Pose gripFromPalm(const Pose& a_from_palm, int side) {
    // Left: x = -y_palm, y = z_palm, z = -x_palm. Right: x = y_palm, y = z_palm, z = x_palm.
    const double h = 0.5;
    const Quat palm_from_grip = side == 0 ? Quat(h, h, -h, -h) : Quat(h, h, h, h);
    return {a_from_palm.rotation * palm_from_grip, a_from_palm.position_m};
}

void Pinches::update(const std::array<double, kPinchFingers>& distances_m) {
    bool closed = false;
    for (std::size_t i = 0; i < kPinchFingers; ++i)
        closed = (fingers[i].closed && fingers[i].update(distances_m[i])) || closed;
    if (closed) return;
    const auto nearest = std::min_element(distances_m.begin(), distances_m.end()) - distances_m.begin();
    fingers[std::size_t(nearest)].update(distances_m[std::size_t(nearest)]);
}

Hands::~Hands() {
    for (const XrHandTrackerEXT tracker : trackers_)
        if (tracker != XR_NULL_HANDLE) calls_.destroyHandTracker(tracker);
}

void Hands::create(const Instance& instance, XrSession session) {
    calls_ = instance.calls;
    if (!instance.supports_hand_tracking || !calls_.createHandTracker || !calls_.locateHandJoints ||
        !calls_.destroyHandTracker)
        return;
    for (std::size_t side = 0; side < 2; ++side) {
        auto info = makeStruct<XrHandTrackerCreateInfoEXT>(XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT);
        info.hand = side == 0 ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT;
        info.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
        if (XR_FAILED(calls_.createHandTracker(session, &info, &trackers_[side])))
            trackers_[side] = XR_NULL_HANDLE;
    }
}

XrResult Hands::locate(XrSpace stage, XrTime time, int side, Joints& joints, bool& tracked) const {
    tracked = false;
    const XrHandTrackerEXT tracker = trackers_[std::size_t(side)];
    if (tracker == XR_NULL_HANDLE) return XR_SUCCESS;
    auto info = makeStruct<XrHandJointsLocateInfoEXT>(XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT);
    info.baseSpace = stage;
    info.time = time;
    auto locations = makeStruct<XrHandJointLocationsEXT>(XR_TYPE_HAND_JOINT_LOCATIONS_EXT);
    locations.jointCount = std::uint32_t(joints.size());
    locations.jointLocations = joints.data();
    const XrResult result = calls_.locateHandJoints(tracker, &info, &locations);
    tracked = XR_SUCCEEDED(result) && locations.isActive;
    return result;
}

XrResult Hands::read(XrSpace stage, XrTime time, int side, Hand& hand) {
    Joints joints{};
    bool tracked = false;
    const XrResult result = locate(stage, time, side, joints, tracked);
    const auto at = [&](XrHandJointEXT joint) {
        const XrHandJointLocationEXT& found = joints[std::size_t(joint)];
        return wholePose(found.locationFlags, found.pose);
    };
    Pinches& pinches = pinches_[std::size_t(side)];
    const auto palm = at(XR_HAND_JOINT_PALM_EXT);
    if (!tracked || !palm) {
        pinches = {};
        return result;
    }
    hand.active = hand.bare = true;
    hand.stage_from_grip = gripFromPalm(*palm, side);
    const auto thumb = at(XR_HAND_JOINT_THUMB_TIP_EXT), index = at(XR_HAND_JOINT_INDEX_TIP_EXT);
    if (!thumb || !index) {
        pinches = {};
        return result;
    }
    Pose aim = *palm;
    aim.position_m = 0.5 * (thumb->position_m + index->position_m);
    hand.stage_from_aim = aim;
    pinches.update({distance_m(thumb, index), distance_m(thumb, at(XR_HAND_JOINT_MIDDLE_TIP_EXT)),
                    distance_m(thumb, at(XR_HAND_JOINT_RING_TIP_EXT))});
    hand.select = pinches.isClosed(PinchFinger::index);
    hand.menu = pinches.isClosed(PinchFinger::middle);
    hand.squeeze = pinches.isClosed(PinchFinger::ring) ? 1.0f : 0.0f;
    return result;
}

std::optional<Pose> Hands::gripAt(XrSpace stage, XrTime time, int side) const {
    Joints joints{};
    bool tracked = false;
    locate(stage, time, side, joints, tracked);
    const XrHandJointLocationEXT& palm = joints[XR_HAND_JOINT_PALM_EXT];
    const auto pose = wholePose(palm.locationFlags, palm.pose, kTracked);
    if (!tracked || !pose) return std::nullopt;
    return gripFromPalm(*pose, side);
}

}  // namespace stylet::xr
