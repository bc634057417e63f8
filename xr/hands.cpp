#include "xr/hands.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stylet::xr {
namespace {

double apart_m(const std::optional<Pose>& a, const std::optional<Pose>& b) {
    if (!a || !b) return std::numeric_limits<double>::infinity();
    return std::hypot(a->position[0] - b->position[0], a->position[1] - b->position[1],
                      a->position[2] - b->position[2]);
}

}  // namespace

// Palm joint: +y points out of the back of the hand, -z along the fingers. Grip: -z points from the little
// finger to the thumb, +x out of the left palm or into the right palm.
Pose gripOfPalm(const Pose& a_from_palm, int side) {
    // Left: x = -y_palm, y = z_palm, z = -x_palm. Right: x = y_palm, y = z_palm, z = x_palm.
    const double h = 0.5;
    const Pose palm_from_grip{
        side == 0 ? std::array<double, 4>{h, -h, -h, h} : std::array<double, 4>{h, h, h, h}, {}};
    return a_from_palm * palm_from_grip;
}

void Pinches::update(const std::array<double, kPinchFingers>& distances_m) {
    bool held = false;
    for (std::size_t i = 0; i < kPinchFingers; ++i)
        held = (fingers[i].held && fingers[i].update(distances_m[i])) || held;
    if (held) return;
    const auto nearest = std::min_element(distances_m.begin(), distances_m.end()) - distances_m.begin();
    fingers[std::size_t(nearest)].update(distances_m[std::size_t(nearest)]);
}

Hands::~Hands() {
    for (const XrHandTrackerEXT tracker : trackers_)
        if (tracker != XR_NULL_HANDLE) calls_.destroyHandTracker(tracker);
}

void Hands::create(const Instance& instance, XrSession session) {
    calls_ = instance.calls;
    if (!instance.tracks_hands || !calls_.createHandTracker || !calls_.locateHandJoints ||
        !calls_.destroyHandTracker)
        return;
    for (std::size_t side = 0; side < 2; ++side) {
        auto info = typed<XrHandTrackerCreateInfoEXT>(XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT);
        info.hand = side == 0 ? XR_HAND_LEFT_EXT : XR_HAND_RIGHT_EXT;
        info.handJointSet = XR_HAND_JOINT_SET_DEFAULT_EXT;
        if (XR_FAILED(calls_.createHandTracker(session, &info, &trackers_[side])))
            trackers_[side] = XR_NULL_HANDLE;
    }
}

XrResult Hands::locate(XrSpace stage, XrTime time, int side, Joints& joints, bool& seen) const {
    seen = false;
    const XrHandTrackerEXT tracker = trackers_[std::size_t(side)];
    if (tracker == XR_NULL_HANDLE) return XR_SUCCESS;
    auto info = typed<XrHandJointsLocateInfoEXT>(XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT);
    info.baseSpace = stage;
    info.time = time;
    auto locations = typed<XrHandJointLocationsEXT>(XR_TYPE_HAND_JOINT_LOCATIONS_EXT);
    locations.jointCount = std::uint32_t(joints.size());
    locations.jointLocations = joints.data();
    const XrResult result = calls_.locateHandJoints(tracker, &info, &locations);
    seen = XR_SUCCEEDED(result) && locations.isActive;
    return result;
}

XrResult Hands::read(XrSpace stage, XrTime time, int side, Hand& hand) {
    Joints joints{};
    bool seen = false;
    const XrResult result = locate(stage, time, side, joints, seen);
    const auto at = [&](XrHandJointEXT joint) {
        const XrHandJointLocationEXT& found = joints[std::size_t(joint)];
        return wholePose(found.locationFlags, found.pose);
    };
    Pinches& pinches = pinches_[std::size_t(side)];
    const auto palm = at(XR_HAND_JOINT_PALM_EXT);
    if (!seen || !palm) {
        pinches = {};
        return result;
    }
    hand.active = hand.bare = true;
    hand.stage_from_grip = gripOfPalm(*palm, side);
    const auto thumb = at(XR_HAND_JOINT_THUMB_TIP_EXT), index = at(XR_HAND_JOINT_INDEX_TIP_EXT);
    if (!thumb || !index) {
        pinches = {};
        return result;
    }
    Pose aim = *palm;
    for (std::size_t i = 0; i < 3; ++i)
        aim.position[i] = 0.5 * (thumb->position[i] + index->position[i]);
    hand.stage_from_aim = aim;
    pinches.update({apart_m(thumb, index), apart_m(thumb, at(XR_HAND_JOINT_MIDDLE_TIP_EXT)),
                    apart_m(thumb, at(XR_HAND_JOINT_RING_TIP_EXT))});
    hand.select = pinches.holds(PinchFinger::index);
    hand.menu = pinches.holds(PinchFinger::middle);
    hand.squeeze = pinches.holds(PinchFinger::ring) ? 1.0f : 0.0f;
    return result;
}

std::optional<Pose> Hands::gripAt(XrSpace stage, XrTime time, int side) const {
    Joints joints{};
    bool seen = false;
    locate(stage, time, side, joints, seen);
    const XrHandJointLocationEXT& palm = joints[XR_HAND_JOINT_PALM_EXT];
    const auto pose = wholePose(palm.locationFlags, palm.pose, kTracked);
    if (!seen || !pose) return std::nullopt;
    return gripOfPalm(*pose, side);
}

}  // namespace stylet::xr
