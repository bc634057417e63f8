// Bone lengths: adult averages from Buryanov and Kotiuk, "Proportions of hand segments", Int. J. Morphol.
// 28(3), 2010, rounded to the millimetre. The last bones include the soft tissue of the fingertip.
#include "world/hand_pose.h"

#include <algorithm>
#include <cmath>

namespace xrmock {

namespace {

struct Bone {
    double length_m;
    double flexion_rad;  // flexion of its joint when fully curled
    double radius_m;     // radius at its joint
};
struct Finger {
    int first;                  // index of the metacarpal joint in XrHandJointEXT
    Vec3 root_m;                // position relative to the palm, right hand
    double spread_rad;          // from metacarpal to proximal bone, away from the thumb
    Vec3 tip_direction;         // direction of the metacarpal bone
    Vec3 back;                  // approximate direction of the finger's back
    std::array<Bone, 4> bones;  // from the metacarpal; the thumb has three
    int bone_count;
    double tip_radius_m;
};

constexpr double kMiddleMetacarpal_m = 0.065;
constexpr double kPalmRadius_m = 0.014;
constexpr double kWristRadius_m = 0.022;
constexpr Vec3 kWrist_m{0, -0.003, kMiddleMetacarpal_m / 2 + 0.026};

constexpr Finger kFingerBones[kFingerCount] = {
    {XR_HAND_JOINT_THUMB_METACARPAL_EXT,
     {-0.019, -0.012, 0.036},
     0,
     {-0.58, -0.20, -0.78},
     {-0.7, 0.7, 0},
     {{{0.046, 0.15, 0.0140}, {0.032, 0.75, 0.0115}, {0.027, 1.30, 0.0100}}},
     3,
     0.0085},
    {XR_HAND_JOINT_INDEX_METACARPAL_EXT,
     {-0.016, 0, 0.034},
     -0.05,
     {-0.14, 0, -1},
     {0, 1, 0},
     {{{0.068, 0, 0.0130}, {0.040, 1.50, 0.0105}, {0.022, 1.75, 0.0090}, {0.020, 1.15, 0.0080}}},
     4,
     0.0070},
    {XR_HAND_JOINT_MIDDLE_METACARPAL_EXT,
     {0, 0, kMiddleMetacarpal_m / 2},
     0,
     {0, 0, -1},
     {0, 1, 0},
     {{{kMiddleMetacarpal_m, 0, 0.0130},
       {0.045, 1.50, 0.0105},
       {0.026, 1.75, 0.0090},
       {0.021, 1.15, 0.0080}}},
     4,
     0.0070},
    {XR_HAND_JOINT_RING_METACARPAL_EXT,
     {0.013, -0.001, 0.030},
     0.05,
     {0.12, 0, -1},
     {0.1, 1, 0},
     {{{0.058, 0.06, 0.0120}, {0.041, 1.50, 0.0100}, {0.026, 1.75, 0.0085}, {0.021, 1.15, 0.0075}}},
     4,
     0.0065},
    {XR_HAND_JOINT_LITTLE_METACARPAL_EXT,
     {0.023, -0.003, 0.027},
     0.12,
     {0.22, 0, -1},
     {0.2, 1, 0},
     {{{0.054, 0.12, 0.0110}, {0.033, 1.50, 0.0090}, {0.018, 1.75, 0.0075}, {0.020, 1.15, 0.0070}}},
     4,
     0.0060},
};

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vec3 unitVector(const Vec3& v) {
    const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return {v[0] / length, v[1] / length, v[2] / length};
}

// Orientation with -z along the direction and +y as close to `back` as possible.
Pose lookAlong(const Vec3& position, const Vec3& direction, const Vec3& back) {
    const Vec3 d = unitVector(direction);
    const Vec3 z{-d[0], -d[1], -d[2]};
    const Vec3 x = unitVector(cross(back, z));
    const Vec3 y = cross(z, x);
    // Quaternion of the matrix with these columns; w is not small for any finger.
    const double w = std::sqrt(std::max(1 + x[0] + y[1] + z[2], 0.0)) / 2;
    const double scale = 1 / (4 * w);
    return {{(y[2] - z[1]) * scale, (z[0] - x[2]) * scale, (x[1] - y[0]) * scale, w}, position};
}

Pose turnX(double angle_rad) {
    return {{std::sin(angle_rad / 2), 0, 0, std::cos(angle_rad / 2)}, {0, 0, 0}};
}

Pose turnY(double angle_rad) {
    return {{0, std::sin(angle_rad / 2), 0, std::cos(angle_rad / 2)}, {0, 0, 0}};
}

// Mirrors a right hand's frame at the plane x = 0.
Pose mirrored(const Pose& pose) {
    const auto& q = pose.orientation;
    const auto& p = pose.position;
    return {{q[0], -q[1], -q[2], q[3]}, {-p[0], p[1], p[2]}};
}

void placeFinger(const Finger& finger, double curl, Joints& palm_from_joints) {
    Pose joint = lookAlong(finger.root_m, finger.tip_direction, finger.back);
    for (int i = 0; i <= finger.bone_count; ++i) {
        const bool tip = i == finger.bone_count;
        if (i == 1) joint = joint * turnY(-finger.spread_rad * (1 - curl));
        if (!tip) joint = joint * turnX(-finger.bones[static_cast<std::size_t>(i)].flexion_rad * curl);
        palm_from_joints[static_cast<std::size_t>(finger.first + i)] = {
            joint, tip ? finger.tip_radius_m : finger.bones[static_cast<std::size_t>(i)].radius_m};
        if (!tip)
            joint = joint * Pose{{0, 0, 0, 1}, {0, 0, -finger.bones[static_cast<std::size_t>(i)].length_m}};
    }
}

// Computes finger curls from the controller's values. The index finger follows the trigger or select
// button, the thumb the thumb controls, and the other fingers the squeeze.
Curls curlsOnControls(const Sources& sources, User user, std::int64_t time_ns) {
    const auto largest = [&](std::initializer_list<const char*> components) {
        double value = 0;
        for (const char* component : components)
            value = std::max(value, inputAt(sources, user, component, time_ns).value);
        return value;
    };
    const double index = largest({"input/trigger/value", "input/trigger/click", "input/select/click"});
    const double handle = largest({"input/squeeze/value", "input/squeeze/click", "input/squeeze/force"});
    const double thumb = largest({"input/thumbstick/touch", "input/thumbstick/click", "input/trackpad/touch",
                                  "input/trackpad/click", "input/thumbrest/touch", "input/menu/click",
                                  "input/a/touch", "input/a/click", "input/b/touch", "input/b/click",
                                  "input/x/touch", "input/x/click", "input/y/touch", "input/y/click"});
    return {thumb, index, handle, handle, handle};
}

}  // namespace

Joints builtInHand(bool is_left, const Pose& stage_from_palm, const Curls& curls) {
    Joints joints;
    joints[XR_HAND_JOINT_PALM_EXT] = {{}, kPalmRadius_m};
    const Vec3 to_middle{0, -kWrist_m[1], kMiddleMetacarpal_m / 2 - kWrist_m[2]};
    joints[XR_HAND_JOINT_WRIST_EXT] = {lookAlong(kWrist_m, to_middle, {0, 1, 0}), kWristRadius_m};
    for (std::size_t finger = 0; finger < kFingerCount; ++finger)
        placeFinger(kFingerBones[finger], curls[finger], joints);
    for (Joint& joint : joints) {
        if (is_left) joint.stage_from_joint = mirrored(joint.stage_from_joint);
        joint.stage_from_joint = stage_from_palm * joint.stage_from_joint;
    }
    return joints;
}

Pose gripFromPalm(bool is_left) {
    // The fingers point along -y of the grip, the back of the hand along +x (right) or -x (left). The grip
    // origin is on the skin of the palm.
    if (is_left) return {{-0.5, 0.5, 0.5, 0.5}, {-kPalmRadius_m, 0, 0}};
    return {{-0.5, -0.5, -0.5, 0.5}, {kPalmRadius_m, 0, 0}};
}

std::optional<Joints> stageFromJoints(const Sources& sources, bool is_left, std::int64_t time_ns) {
    const User user = is_left ? User::left_hand : User::right_hand;
    const TrackedHand& hand = sources.scenario.hands[static_cast<std::size_t>(user)];
    const double t_s = sources.clock.scenarioSeconds(time_ns);
    const bool held = !profileAt(sources, user, time_ns).empty();
    const bool scripted = !hand.tracked.empty() && hand.tracked.front().t_s <= t_s;
    const bool visible =
        scripted ? valueAt(hand.tracked, t_s) > 0 : held || !hand.joints.empty() || !hand.palms.empty();
    if (!visible) return std::nullopt;
    if (!hand.joints.empty()) return jointsAt(hand.joints, t_s);
    const Curls curls =
        hand.curls.empty() && held ? curlsOnControls(sources, user, time_ns) : curlsAt(hand.curls, t_s);
    const Pose stage_from_palm =
        hand.palms.empty()
            ? stageFromSource(sources, user, "input/grip/pose", time_ns) * gripFromPalm(is_left)
            : poseAt(hand.palms, t_s);
    return builtInHand(is_left, stage_from_palm, curls);
}

}  // namespace xrmock
