// What the scenario's user holds, wears and does with the fingers, over time.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "keys.h"
#include "openxr_api.h"

namespace xrmock {

// The top level user paths. The hands come first: their numbers index whatever there is per hand.
enum class User : std::size_t { left_hand, right_hand, head, gamepad, treadmill };
constexpr std::size_t kUserCount = 5;
constexpr std::size_t kHandCount = 2;

std::string_view userPath(User user);  // "/user/hand/left"
std::optional<User> userOf(std::string_view path);
constexpr bool isHand(User user) {
    return static_cast<std::size_t>(user) < kHandCount;
}

struct Device {
    std::vector<TextKey> profiles;  // the interaction profile; empty: not connected
    std::vector<PoseKey> grips;     // hands only; not connected, a hand still has a pose
    Pose grip_from_aim;
    std::map<std::string, std::vector<ValueKey>, std::less<>> values;  // by component, "input/select/click"
};

constexpr std::size_t kFingerCount = 5;          // from the thumb to the little finger
using Curls = std::array<double, kFingerCount>;  // 0 straight, 1 in the fist
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

// What XR_EXT_hand_tracking sees of a hand. Recorded joints go before palm poses, these before the grip of
// what the hand holds.
struct TrackedHand {
    std::vector<JointsKey> joints;
    std::vector<PoseKey> palms;
    std::vector<CurlKey> curls;
    std::vector<ValueKey> tracked;  // 0 hides the hand; no keys: seen whenever there is anything to see
};

// Two simple controllers resting in front.
std::array<Device, kUserCount> restingDevices();
// The hands that hold something hold this (empty: nothing) from a time on, until the next key.
void takeUp(std::array<Device, kUserCount>& devices, const std::string& profile, double from_s);

// Linear between the keys; straight fingers without any.
Curls curlsAt(const std::vector<CurlKey>& keys, double t_s);
// Joint by joint, as poses. Never without keys.
Joints jointsAt(const std::vector<JointsKey>& keys, double t_s);

}  // namespace xrmock
