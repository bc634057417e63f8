// Tracked bare hands (XR_EXT_hand_tracking), presented like a controller: grip pose, aim pose and pinches.
#pragma once

#include <array>

#include "xr/instance.h"
#include "xr/pose.h"

namespace stylet::xr {

// A pinch of thumb and one finger, with hysteresis: it closes below kClosed_m and opens at kOpen_m.
struct Pinch {
    // Distances between the tip joints, which lie inside the skin.
    static constexpr double kClosed_m = 0.020, kOpen_m = 0.035;
    bool closed = false;
    bool update(double distance_m) {
        closed = distance_m < (closed ? kOpen_m : kClosed_m);
        return closed;
    }
};

// The fingers whose pinch acts as trigger, menu button and squeeze.
enum class PinchFinger : int { index, middle, ring };
inline constexpr std::size_t kPinchFingers = 3;

// Only one pinch at a time: neighbouring fingers move together, so the first pinch blocks the others until
// it opens.
struct Pinches {
    std::array<Pinch, kPinchFingers> fingers;
    // Distances from the thumb's tip; infinite for a finger that is not tracked.
    void update(const std::array<double, kPinchFingers>& distances_m);
    bool isClosed(PinchFinger finger) const { return fingers[std::size_t(finger)].closed; }
};

// Computes the grip pose (OpenXR 1.0, section 6.3.2, "Standard pose identifier") from the palm joint's
// pose.
Pose gripFromPalm(const Pose& a_from_palm, int side);

class Hands {
  public:
    Hands() = default;
    ~Hands();
    Hands(const Hands&) = delete;
    Hands& operator=(const Hands&) = delete;

    void create(const Instance&, XrSession);  // no effect if the system does not track hands
    // Leaves `hand` unchanged if the hand is not tracked.
    XrResult read(XrSpace stage, XrTime, int side, Hand& hand);
    // Any thread.
    std::optional<Pose> gripAt(XrSpace stage, XrTime, int side) const;

  private:
    using Joints = std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT>;
    XrResult locate(XrSpace stage, XrTime, int side, Joints&, bool& tracked) const;

    ExtensionCalls calls_;
    std::array<XrHandTrackerEXT, 2> trackers_{XR_NULL_HANDLE, XR_NULL_HANDLE};
    std::array<Pinches, 2> pinches_;
};

}  // namespace stylet::xr
