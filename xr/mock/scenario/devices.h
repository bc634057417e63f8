// Scripted devices over time: the devices that the user holds and wears, and the tracked hands.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenario/keys.h"
#include "scenario/openxr_api.h"

namespace xrmock {

// Top level user paths. The hands come first, so that their values index per-hand arrays.
enum class User : std::size_t { left_hand, right_hand, head, gamepad, treadmill };
constexpr std::size_t kUserCount = 5;
constexpr std::size_t kHandCount = 2;

std::string_view userPath(User user);  // "/user/hand/left"
std::optional<User> findUser(std::string_view path);
constexpr bool isHand(User user) {
    return static_cast<std::size_t>(user) < kHandCount;
}

struct Device {
    std::vector<TextKey> profiles;  // interaction profile; empty: not connected
    std::vector<PoseKey> grips;     // hands only; a hand has a pose even if nothing is connected
    Pose grip_from_aim;
    std::map<std::string, std::vector<ValueKey>, std::less<>> values;  // by component, "input/select/click"
};

constexpr std::size_t kFingerCount = 5;          // from the thumb to the little finger
using Curls = std::array<double, kFingerCount>;  // 0 straight, 1 in a fist
struct CurlKey {
    double t_s;
    Curls curls;
};

struct Joint {
    Pose stage_from_joint;
    double radius_m;
};
using Joints = std::array<Joint, XR_HAND_JOINT_COUNT_EXT>;  // by XrHandJointEXT
struct JointsKey {
    double t_s;
    Joints joints;
};

// A hand as seen by XR_EXT_hand_tracking. Recorded joints have priority over palm poses, and palm poses
// over the grip pose of a held controller.
struct TrackedHand {
    std::vector<JointsKey> joints;
    std::vector<PoseKey> palms;
    std::vector<CurlKey> curls;
    // 0: hidden. Without keys: visible if it has joints, palm poses or a held controller.
    std::vector<ValueKey> tracked;
};

// Two simple controllers at rest in front of the user.
std::array<Device, kUserCount> restingDevices();
// From `from_s` until the next key, every hand that holds a controller holds `profile` instead. An empty
// `profile` means nothing.
void switchProfile(std::array<Device, kUserCount>& devices, const std::string& profile, double from_s);

// Interpolates linearly. Straight fingers if there are no keys.
Curls curlsAt(const std::vector<CurlKey>& keys, double t_s);
// Interpolates each joint's pose. `keys` must not be empty.
Joints jointsAt(const std::vector<JointsKey>& keys, double t_s);

}  // namespace xrmock
