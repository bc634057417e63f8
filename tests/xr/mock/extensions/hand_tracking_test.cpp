// XR_EXT_hand_tracking: validity flags, and the anatomy of the built-in hand.
#include <cmath>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

using Vec = std::array<double, 3>;

Vec minus(const Vec& a, const Vec& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
double dot(const Vec& a, const Vec& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
double length(const Vec& v) {
    return std::sqrt(dot(v, v));
}
Vec cross(const Vec& a, const Vec& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The first joint of each finger. The thumb has four joints, the others five.
constexpr int kRoots[] = {XR_HAND_JOINT_THUMB_METACARPAL_EXT, XR_HAND_JOINT_INDEX_METACARPAL_EXT,
                          XR_HAND_JOINT_MIDDLE_METACARPAL_EXT, XR_HAND_JOINT_RING_METACARPAL_EXT,
                          XR_HAND_JOINT_LITTLE_METACARPAL_EXT};
constexpr int kTips[] = {XR_HAND_JOINT_THUMB_TIP_EXT, XR_HAND_JOINT_INDEX_TIP_EXT,
                         XR_HAND_JOINT_MIDDLE_TIP_EXT, XR_HAND_JOINT_RING_TIP_EXT,
                         XR_HAND_JOINT_LITTLE_TIP_EXT};

struct Located {
    XrBool32 active = XR_TRUE;
    std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT> joints{};
    std::array<XrHandJointVelocityEXT, XR_HAND_JOINT_COUNT_EXT> velocities{};

    Vec position(int joint) const {
        const XrVector3f& p = joints[static_cast<std::size_t>(joint)].pose.position;
        return {p.x, p.y, p.z};
    }
    // An axis of the joint's frame (0 = x, 1 = y, 2 = z).
    Vec axis(int joint, int which) const {
        const XrQuaternionf& q = joints[static_cast<std::size_t>(joint)].pose.orientation;
        const double x = q.x, y = q.y, z = q.z, w = q.w;
        if (which == 0) return {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)};
        if (which == 1) return {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)};
        return {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
    }
};

class HandTracking : public MockTest {
  protected:
    bool isSupported() {
        auto hands =
            makeStruct<XrSystemHandTrackingPropertiesEXT>(XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT);
        hands.supportsHandTracking = 7;  // neither XR_TRUE nor XR_FALSE
        auto properties = makeStruct<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
        properties.next = &hands;
        EXPECT_EQ(xrGetSystemProperties(instance_, system_, &properties), XR_SUCCESS);
        EXPECT_LE(hands.supportsHandTracking, XR_TRUE);
        return hands.supportsHandTracking == XR_TRUE;
    }
    XrHandTrackerEXT tracker(XrHandEXT hand) {
        XrHandTrackerEXT result = XR_NULL_HANDLE;
        EXPECT_EQ(tryTracker(hand, XR_HAND_JOINT_SET_DEFAULT_EXT, &result), XR_SUCCESS);
        return result;
    }
    XrResult tryTracker(XrHandEXT hand, XrHandJointSetEXT joints, XrHandTrackerEXT* out) {
        const XrHandTrackerCreateInfoEXT info{XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, nullptr, hand, joints};
        return load<PFN_xrCreateHandTrackerEXT>(instance_, "xrCreateHandTrackerEXT")(session_, &info, out);
    }
    XrResult tryLocate(XrHandTrackerEXT hand, XrSpace base, XrTime time, XrHandJointLocationsEXT& locations) {
        const XrHandJointsLocateInfoEXT info{XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, nullptr, base, time};
        return load<PFN_xrLocateHandJointsEXT>(instance_, "xrLocateHandJointsEXT")(hand, &info, &locations);
    }
    Located locate(XrHandTrackerEXT hand, XrTime time, XrSpace base = XR_NULL_HANDLE) {
        Located result;
        XrHandJointVelocitiesEXT velocities{XR_TYPE_HAND_JOINT_VELOCITIES_EXT, nullptr,
                                            XR_HAND_JOINT_COUNT_EXT, result.velocities.data()};
        XrHandJointLocationsEXT locations{XR_TYPE_HAND_JOINT_LOCATIONS_EXT, &velocities, XR_FALSE,
                                          XR_HAND_JOINT_COUNT_EXT, result.joints.data()};
        EXPECT_EQ(tryLocate(hand, base == XR_NULL_HANDLE ? stage_ : base, time, locations), XR_SUCCESS);
        result.active = locations.isActive;
        for (std::size_t i = 0; i < result.joints.size(); ++i) {
            EXPECT_EQ(result.joints[i].locationFlags, result.active ? 15U : 0U);
            EXPECT_EQ(result.velocities[i].velocityFlags, result.active ? 3U : 0U);
            if (result.active) {
                EXPECT_GT(result.joints[i].radius, 0.004F);
                EXPECT_LT(result.joints[i].radius, 0.03F);
            }
        }
        return result;
    }
};

TEST_F(HandTracking, TheSystemReportsSupport) {
    start();
    EXPECT_TRUE(isSupported());
}

TEST_F(HandTracking, AnUnsupportedSystemRefusesTrackers) {
    setScript(R"({"version": 2, "hands": {"supported": false}})");
    startSession();
    EXPECT_FALSE(isSupported());
    XrHandTrackerEXT hand = XR_NULL_HANDLE;
    EXPECT_EQ(tryTracker(XR_HAND_LEFT_EXT, XR_HAND_JOINT_SET_DEFAULT_EXT, &hand),
              XR_ERROR_FEATURE_UNSUPPORTED);
}

TEST_F(HandTracking, RefusesWrongCountsTimesAndValues) {
    startFocused();
    XrHandTrackerEXT hand = XR_NULL_HANDLE;
    EXPECT_EQ(tryTracker(static_cast<XrHandEXT>(3), XR_HAND_JOINT_SET_DEFAULT_EXT, &hand),
              XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(tryTracker(XR_HAND_LEFT_EXT, static_cast<XrHandJointSetEXT>(7), &hand),
              XR_ERROR_VALIDATION_FAILURE);
    hand = tracker(XR_HAND_LEFT_EXT);
    Located room;
    XrHandJointLocationsEXT locations{XR_TYPE_HAND_JOINT_LOCATIONS_EXT, nullptr, XR_FALSE,
                                      XR_HAND_JOINT_COUNT_EXT, room.joints.data()};
    EXPECT_EQ(tryLocate(hand, stage_, 0, locations), XR_ERROR_TIME_INVALID);
    EXPECT_EQ(locations.isActive, XR_FALSE);
    EXPECT_EQ(tryLocate(hand, XR_NULL_HANDLE, 1, locations), XR_ERROR_HANDLE_INVALID);
    locations.jointCount = XR_HAND_JOINT_COUNT_EXT - 1;
    EXPECT_EQ(tryLocate(hand, stage_, 1, locations), XR_ERROR_VALIDATION_FAILURE);
    locations.jointCount = XR_HAND_JOINT_COUNT_EXT;
    XrHandJointVelocitiesEXT velocities{XR_TYPE_HAND_JOINT_VELOCITIES_EXT, nullptr,
                                        XR_HAND_JOINT_COUNT_EXT - 1, room.velocities.data()};
    locations.next = &velocities;
    EXPECT_EQ(tryLocate(hand, stage_, 1, locations), XR_ERROR_VALIDATION_FAILURE);
    velocities.jointCount = XR_HAND_JOINT_COUNT_EXT;
    EXPECT_EQ(tryLocate(hand, stage_, 1, locations), XR_SUCCESS);
    const auto destroy = load<PFN_xrDestroyHandTrackerEXT>(instance_, "xrDestroyHandTrackerEXT");
    EXPECT_EQ(destroy(hand), XR_SUCCESS);
    EXPECT_EQ(destroy(hand), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(tryLocate(hand, stage_, 1, locations), XR_ERROR_HANDLE_INVALID);
}

TEST_F(HandTracking, NeedsFocusAndAHand) {
    setScript(R"({"version": 2, "controllers": {"left": {}}, "hands": {
        "left": {"tracked": [{"t_s": 0.5, "tracked": false}, {"t_s": 1.5, "tracked": true}]}}})");
    startRunning();
    const XrHandTrackerEXT left = tracker(XR_HAND_LEFT_EXT), right = tracker(XR_HAND_RIGHT_EXT);
    EXPECT_FALSE(locate(left, 2'000'000'000).active);
    for (int i = 0; i < 3; ++i)
        frame();
    EXPECT_TRUE(locate(left, 100'000'000).active);
    EXPECT_FALSE(locate(left, 1'000'000'000).active);
    EXPECT_TRUE(locate(left, 2'000'000'000).active);
    EXPECT_FALSE(locate(right, 2'000'000'000).active);
    ASSERT_EQ(xrRequestExitSession(session_), XR_SUCCESS);
    EXPECT_FALSE(locate(left, 2'000'000'000).active);
}

// Straight hands, palms down, fingers forward: the palm frame is not rotated.
constexpr char kFlat[] = R"({"version": 2, "hands": {
    "left": {"poses": [{"t_s": 0, "position": [-0.2, 1, 0]}], "curls": [{"t_s": 0}, {"t_s": 2, "thumb": 1,
             "index": 1, "middle": 1, "ring": 1, "little": 1}]},
    "right": {"poses": [{"t_s": 0, "position": [0.2, 1, 0]}], "curls": [{"t_s": 0}, {"t_s": 2, "thumb": 1,
             "index": 1, "middle": 1, "ring": 1, "little": 1}]}}})";

TEST_F(HandTracking, TheFramesAreThoseOfTheExtension) {
    setScript(kFlat);
    startFocused();
    for (const XrHandEXT side : {XR_HAND_LEFT_EXT, XR_HAND_RIGHT_EXT}) {
        const XrHandTrackerEXT hand = tracker(side);
        for (const XrTime time : {XrTime{1}, XrTime{1'000'000'000}, XrTime{2'000'000'000}}) {
            const Located at = locate(hand, time);
            ASSERT_TRUE(at.active);
            // +z of every joint points from the next joint to this one, and the axes are right-handed.
            for (std::size_t finger = 0; finger < 5; ++finger) {
                for (int joint = kRoots[finger]; joint <= kTips[finger]; ++joint) {
                    EXPECT_NEAR(dot(cross(at.axis(joint, 0), at.axis(joint, 1)), at.axis(joint, 2)), 1, 1e-5);
                    if (joint == kTips[finger]) continue;
                    const Vec bone = minus(at.position(joint), at.position(joint + 1));
                    EXPECT_NEAR(dot(bone, at.axis(joint, 2)), length(bone), 1e-5) << joint;
                    // No joint bends backwards: the next bone turns toward the palm.
                    EXPECT_GT(dot(at.axis(joint + 1, 2), at.axis(joint, 1)), -0.02) << joint;
                }
            }
            const Vec middle = at.position(XR_HAND_JOINT_MIDDLE_METACARPAL_EXT);
            const Vec knuckle = at.position(XR_HAND_JOINT_MIDDLE_PROXIMAL_EXT);
            const Vec palm = at.position(XR_HAND_JOINT_PALM_EXT);
            for (std::size_t i = 0; i < 3; ++i)
                EXPECT_NEAR(palm[i], (middle[i] + knuckle[i]) / 2, 1e-6);
            for (int which = 0; which < 3; ++which) {
                EXPECT_NEAR(dot(at.axis(XR_HAND_JOINT_PALM_EXT, which),
                                at.axis(XR_HAND_JOINT_MIDDLE_METACARPAL_EXT, which)),
                            1, 1e-5);
            }
            const Vec to_wrist = minus(at.position(XR_HAND_JOINT_WRIST_EXT), middle);
            EXPECT_NEAR(dot(to_wrist, at.axis(XR_HAND_JOINT_WRIST_EXT, 2)), length(to_wrist), 1e-6);
        }
    }
}

TEST_F(HandTracking, BonesKeepTheirLengthsAndThumbsAreInside) {
    setScript(kFlat);
    startFocused();
    const Located left = locate(tracker(XR_HAND_LEFT_EXT), 1), right = locate(tracker(XR_HAND_RIGHT_EXT), 1);
    const Located fist = locate(tracker(XR_HAND_RIGHT_EXT), 2'000'000'000);
    for (std::size_t finger = 0; finger < 5; ++finger) {
        double open = 0;
        for (int joint = kRoots[finger]; joint < kTips[finger]; ++joint) {
            const double bone = length(minus(right.position(joint), right.position(joint + 1)));
            open += bone;
            EXPECT_NEAR(bone, length(minus(fist.position(joint), fist.position(joint + 1))), 1e-6);
            EXPECT_NEAR(bone, length(minus(left.position(joint), left.position(joint + 1))), 1e-6);
            EXPECT_GT(bone, 0.015);
            EXPECT_LT(bone, 0.08);
            // Bones get shorter toward the tip. The last ones are excluded, because they include the flesh.
            if (joint > kRoots[finger] && joint + 1 < kTips[finger]) {
                EXPECT_LT(bone, length(minus(right.position(joint - 1), right.position(joint))));
            }
        }
        // An open finger is nearly as long as the sum of its bones. A curled finger ends near the palm.
        EXPECT_GT(length(minus(right.position(kTips[finger]), right.position(kRoots[finger]))), 0.97 * open);
        const double tip_to_palm =
            length(minus(fist.position(kTips[finger]), fist.position(XR_HAND_JOINT_PALM_EXT)));
        EXPECT_LT(tip_to_palm, 0.075) << finger;
        EXPECT_GT(tip_to_palm, 0.012) << finger;
        // The tip of a curled finger is on the palm's side of the hand.
        EXPECT_LT(fist.position(kTips[finger])[1], fist.position(XR_HAND_JOINT_PALM_EXT)[1] - 0.01) << finger;
    }
    // The middle finger is the longest, and an adult's hand is 17 to 21 cm long.
    const auto reach = [&](int tip) {
        return length(minus(right.position(tip), right.position(XR_HAND_JOINT_WRIST_EXT)));
    };
    for (const int tip : kTips)
        EXPECT_LE(reach(tip), reach(XR_HAND_JOINT_MIDDLE_TIP_EXT));
    EXPECT_GT(reach(XR_HAND_JOINT_MIDDLE_TIP_EXT), 0.17);
    EXPECT_LT(reach(XR_HAND_JOINT_MIDDLE_TIP_EXT), 0.21);
    // Palms down, thumbs toward each other. From thumb to little finger, each tip is farther outward than the
    // previous one.
    for (const auto& [hand, out] : {std::pair{&left, -1.0}, std::pair{&right, 1.0}}) {
        for (std::size_t finger = 0; finger + 1 < 5; ++finger)
            EXPECT_LT(out * hand->position(kTips[finger])[0], out * hand->position(kTips[finger + 1])[0]);
        EXPECT_GT(hand->axis(XR_HAND_JOINT_INDEX_DISTAL_EXT, 1)[1], 0.95);  // the nail points up
        EXPECT_LT(hand->position(XR_HAND_JOINT_MIDDLE_TIP_EXT)[2], -0.1);
    }
    for (int joint = 0; joint < XR_HAND_JOINT_COUNT_EXT; ++joint) {
        EXPECT_NEAR(left.position(joint)[0], -right.position(joint)[0], 1e-6);
        EXPECT_NEAR(left.position(joint)[1], right.position(joint)[1], 1e-6);
        EXPECT_NEAR(left.position(joint)[2], right.position(joint)[2], 1e-6);
    }
}

// The controllers are held upright. The backs of the hands face outward and the open fingers point forward.
TEST_F(HandTracking, AHandWithAControllerFollowsItsGrip) {
    setScript(R"({"version": 2, "refresh_hz": 100, "controllers": {
        "left": {"poses": [{"t_s": 0, "position": [-0.2, 1, 0],
                            "orientation": [0.7071067811865476, 0, 0, 0.7071067811865476]}]},
        "right": {"poses": [{"t_s": 0, "position": [0.2, 1, 0],
                             "orientation": [0.7071067811865476, 0, 0, 0.7071067811865476]}],
                  "values": [{"t_s": 1.5, "select/click": true}]}}})");
    startFocused();
    for (const auto& [side, out] : {std::pair{XR_HAND_LEFT_EXT, -1.0}, std::pair{XR_HAND_RIGHT_EXT, 1.0}}) {
        const XrHandTrackerEXT hand = tracker(side);
        const Located at = locate(hand, 1'000'000'000);
        ASSERT_TRUE(at.active);
        EXPECT_NEAR(at.axis(XR_HAND_JOINT_PALM_EXT, 1)[0], out, 1e-5);
        EXPECT_NEAR(at.axis(XR_HAND_JOINT_PALM_EXT, 2)[2], 1, 1e-5);
        EXPECT_GT(at.position(XR_HAND_JOINT_THUMB_TIP_EXT)[1], at.position(XR_HAND_JOINT_LITTLE_TIP_EXT)[1]);
        // The grip pose lies on the palm's skin.
        EXPECT_NEAR(at.position(XR_HAND_JOINT_PALM_EXT)[0] - out * at.joints[XR_HAND_JOINT_PALM_EXT].radius,
                    out * 0.2, 1e-6);
        // The index finger curls with the trigger.
        const Located pressed = locate(hand, 1'600'000'000);
        const double moved = length(
            minus(pressed.position(XR_HAND_JOINT_INDEX_TIP_EXT), at.position(XR_HAND_JOINT_INDEX_TIP_EXT)));
        EXPECT_EQ(moved > 0.05, side == XR_HAND_RIGHT_EXT) << moved;
    }
}

TEST_F(HandTracking, VelocitiesAreThoseOfTheBaseSpace) {
    setScript(R"({"version": 2, "hands": {"right": {"poses": [
        {"t_s": 0, "position": [0, 1, 0]}, {"t_s": 1, "position": [1, 1, 0]},
        {"t_s": 2, "position": [1, 1, 0], "orientation": [0, 0.7071067811865476, 0, 0.7071067811865476]}]}}})");
    startFocused();
    const XrHandTrackerEXT hand = tracker(XR_HAND_RIGHT_EXT);
    const Located sliding = locate(hand, 500'000'000);
    for (const XrHandJointVelocityEXT& each : sliding.velocities) {
        EXPECT_NEAR(each.linearVelocity.x, 1, 1e-5);
        EXPECT_NEAR(each.linearVelocity.z, 0, 1e-5);
        EXPECT_NEAR(each.angularVelocity.y, 0, 1e-5);
    }
    const Located turning = locate(hand, 1'500'000'000);
    const Vec arm =
        minus(turning.position(XR_HAND_JOINT_MIDDLE_TIP_EXT), turning.position(XR_HAND_JOINT_PALM_EXT));
    const Vec expected = cross({0, 1.5707963, 0}, arm);
    const XrHandJointVelocityEXT& tip = turning.velocities[XR_HAND_JOINT_MIDDLE_TIP_EXT];
    EXPECT_NEAR(tip.angularVelocity.y, 1.5707963, 1e-4);
    EXPECT_NEAR(tip.linearVelocity.x, expected[0], 1e-4);
    EXPECT_NEAR(tip.linearVelocity.z, expected[2], 1e-4);
    // The same hand, located in a space that is turned by half a turn about y.
    const XrSpace turned = createSpace(XR_REFERENCE_SPACE_TYPE_STAGE, {{0, 1, 0, 0}, {0, 0, 0}});
    const Located seen = locate(hand, 500'000'000, turned);
    EXPECT_NEAR(seen.velocities[XR_HAND_JOINT_PALM_EXT].linearVelocity.x, -1, 1e-5);
    EXPECT_NEAR(seen.position(XR_HAND_JOINT_PALM_EXT)[0], -0.5, 1e-6);
}

TEST_F(HandTracking, RecordedJointsAreReproduced) {
    std::string joints;
    for (int i = 0; i < XR_HAND_JOINT_COUNT_EXT; ++i)
        joints += (i == 0 ? "[" : ",[") + std::to_string(i) + ",0,0,0,0,0,1,0.0" +
                  std::to_string(10 + i % 10) + "]";
    std::string later = joints;
    setScript(R"({"version": 2, "hands": {"left": {"joints": [{"t_s": 0, "joints": [)" + joints +
              R"(]}, {"t_s": 2, "joints": [)" + later + "]}]}}}");
    startFocused();
    const Located at = locate(tracker(XR_HAND_LEFT_EXT), 1'000'000'000);
    ASSERT_TRUE(at.active);
    EXPECT_FLOAT_EQ(at.joints[7].pose.position.x, 7);
    EXPECT_FLOAT_EQ(at.joints[7].radius, 0.017F);
}

}  // namespace
}  // namespace mock_test
