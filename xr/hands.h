// Bare hands (XR_EXT_hand_tracking) as what a controller would say: a grip, where it points, and pinches.
#pragma once

#include <array>

#include "xr/instance.h"
#include "xr/pose.h"

namespace stylet::xr {

// Thumb and a finger: held from nearer than one distance until farther than the other.
struct Pinch {
    static constexpr double kClosed_m = 0.020, kOpen_m = 0.035;  // between the tips' joints, inside the skin
    bool held = false;
    bool update(double distance_m) {
        held = distance_m < (held ? kOpen_m : kClosed_m);
        return held;
    }
};

// The fingers that stand for a trigger, a menu button and a squeeze.
enum class PinchFinger : int { index, middle, ring };
inline constexpr std::size_t kPinchFingers = 3;

// One at a time: fingers keep each other company, so the first to come counts until it has gone.
struct Pinches {
    std::array<Pinch, kPinchFingers> fingers;
    // Distances from the thumb's tip; infinite of a finger that is not seen.
    void update(const std::array<double, kPinchFingers>& distances_m);
    bool holds(PinchFinger finger) const { return fingers[std::size_t(finger)].held; }
};

// A grip pose as OpenXR 1.0, section 6.3.2, "Standard pose identifier", has it, from a palm joint's.
Pose gripOfPalm(const Pose& a_from_palm, int side);

class Hands {
  public:
    Hands() = default;
    ~Hands();
    Hands(const Hands&) = delete;
    Hands& operator=(const Hands&) = delete;

    void create(const Instance&, XrSession);  // nothing comes of it where hands are not tracked
    // A hand that is not seen leaves `hand` as it is.
    XrResult read(XrSpace stage, XrTime, int side, Hand& hand);
    // Any thread.
    std::optional<Pose> gripAt(XrSpace stage, XrTime, int side) const;

  private:
    using Joints = std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT>;
    XrResult locate(XrSpace stage, XrTime, int side, Joints&, bool& seen) const;

    ExtensionCalls calls_;
    std::array<XrHandTrackerEXT, 2> trackers_{XR_NULL_HANDLE, XR_NULL_HANDLE};
    std::array<Pinches, 2> pinches_;
};

}  // namespace stylet::xr
