#include <algorithm>
#include <cmath>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

// From 1 s to 3 s the head moves 2 m along -z and makes half a turn about y. At the start it looks to the
// left (a quarter turn).
constexpr char kWalk[] = R"({"version": 1, "refresh_hz": 100,
    "eyes": {"ipd_m": 0.06, "left_fov_rad": [-0.8, 0.7, 0.6, -0.5], "right_fov_rad": [-0.7, 0.8, 0.6, -0.5]},
    "head": [{"t_s": 1, "position": [1, 1.5, 0], "orientation": [0, 0.70710678, 0, 0.70710678]},
             {"t_s": 3, "position": [1, 1.5, -2], "orientation": [0, 0.70710678, 0, -0.70710678]}]})";

class Space : public MockTest {
  protected:
    bool offers(XrReferenceSpaceType type) {
        std::uint32_t count = 0;
        EXPECT_EQ(xrEnumerateReferenceSpaces(session_, 0, &count, nullptr), XR_SUCCESS);
        std::vector<XrReferenceSpaceType> types(count);
        EXPECT_EQ(xrEnumerateReferenceSpaces(session_, 1, &count, types.data()), XR_ERROR_SIZE_INSUFFICIENT);
        EXPECT_EQ(xrEnumerateReferenceSpaces(session_, count, &count, types.data()), XR_SUCCESS);
        return std::find(types.begin(), types.end(), type) != types.end();
    }
    static void expectNear(const XrVector3f& actual, float x, float y, float z) {
        EXPECT_NEAR(actual.x, x, 1e-5F);
        EXPECT_NEAR(actual.y, y, 1e-5F);
        EXPECT_NEAR(actual.z, z, 1e-5F);
    }
};

TEST_F(Space, TheHeadFollowsTheScenario) {
    setScript(kWalk);
    startSession();
    const XrSpace view = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    const float quarter = std::sqrt(0.5F);
    XrSpaceLocation head = locate(view, stage_, 500'000'000);
    EXPECT_EQ(head.locationFlags, 15U);
    expectNear(head.pose.position, 1, 1.5F, 0);
    EXPECT_NEAR(head.pose.orientation.y, quarter, 1e-6F);
    head = locate(view, stage_, 2'000'000'000);  // halfway: it looks along the stage's +z
    expectNear(head.pose.position, 1, 1.5F, -1);
    EXPECT_NEAR(std::abs(head.pose.orientation.y), 1, 1e-6F);
    head = locate(view, stage_, 9'000'000'000);
    expectNear(head.pose.position, 1, 1.5F, -2);
}

TEST_F(Space, TransformsCancel) {
    setScript(kWalk);
    startSession();
    // LOCAL's origin is at (1, 1.5, 0), and its -z is the stage's -x.
    const XrSpace local = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    expectNear(locate(local, stage_, 1).pose.position, 1, 1.5F, 0);
    expectNear(locate(stage_, local, 1).pose.position, 0, -1.5F, -1);
    const XrSpace ahead = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, -2}});
    expectNear(locate(ahead, stage_, 1).pose.position, -1, 1.5F, 0);
    expectNear(locate(ahead, local, 1).pose.position, 0, 0, -2);
    expectNear(locate(ahead, ahead, 1).pose.position, 0, 0, 0);
}

TEST_F(Space, VelocitiesFollowTheScenario) {
    setScript(kWalk);
    startSession();
    const XrSpace view = createSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    auto velocity = makeStruct<XrSpaceVelocity>(XR_TYPE_SPACE_VELOCITY);
    locate(view, stage_, 2'000'000'000, &velocity);
    EXPECT_EQ(velocity.velocityFlags, 3U);
    EXPECT_NEAR(velocity.linearVelocity.z, -1, 1e-3F);
    EXPECT_NEAR(velocity.angularVelocity.y, 3.14159265F / 2, 1e-3F);
    locate(view, view, 2'000'000'000, &velocity);
    EXPECT_NEAR(velocity.linearVelocity.z, 0, 1e-6F);
}

TEST_F(Space, EyesAreOffsetFromTheHead) {
    setScript(kWalk);
    startSession();
    auto state = makeStruct<XrViewState>(XR_TYPE_VIEW_STATE);
    XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                          1'000'000'000, stage_};
    std::array<XrView, 2> views{makeStruct<XrView>(XR_TYPE_VIEW), makeStruct<XrView>(XR_TYPE_VIEW)};
    std::uint32_t count = 0;
    EXPECT_EQ(xrLocateViews(session_, &info, &state, 0, &count, nullptr), XR_ERROR_VALIDATION_FAILURE);
    const XrSessionBeginInfo begin_info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, info.viewConfigurationType};
    ASSERT_EQ(xrBeginSession(session_, &begin_info), XR_SUCCESS);
    ASSERT_EQ(xrLocateViews(session_, &info, &state, 0, &count, nullptr), XR_SUCCESS);
    ASSERT_EQ(count, 2U);
    EXPECT_EQ(xrLocateViews(session_, &info, &state, 1, &count, views.data()), XR_ERROR_SIZE_INSUFFICIENT);
    ASSERT_EQ(xrLocateViews(session_, &info, &state, 2, &count, views.data()), XR_SUCCESS);
    EXPECT_EQ(state.viewStateFlags, 15U);
    // With the head a quarter turn to the left, the left eye is toward +z.
    expectNear(views[0].pose.position, 1, 1.5F, 0.03F);
    expectNear(views[1].pose.position, 1, 1.5F, -0.03F);
    EXPECT_FLOAT_EQ(views[0].fov.angleLeft, -0.8F);
    EXPECT_FLOAT_EQ(views[1].fov.angleRight, 0.8F);
    EXPECT_FLOAT_EQ(views[1].fov.angleDown, -0.5F);
    info.displayTime = 0;
    EXPECT_EQ(xrLocateViews(session_, &info, &state, 2, &count, views.data()), XR_ERROR_TIME_INVALID);
    info.displayTime = 1;
    info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO;
    EXPECT_EQ(xrLocateViews(session_, &info, &state, 2, &count, views.data()),
              XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
    info.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
    info.space = XR_NULL_HANDLE;
    EXPECT_EQ(xrLocateViews(session_, &info, &state, 2, &count, views.data()), XR_ERROR_HANDLE_INVALID);
}

TEST_F(Space, RefusesBadPosesTypesAndTimes) {
    startSession();
    XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO,
                                    nullptr,
                                    XR_REFERENCE_SPACE_TYPE_LOCAL,
                                    {{0, 0, 0, 0}, {0, 0, 0}}};
    XrSpace space = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_ERROR_POSE_INVALID);
    info.poseInReferenceSpace = kIdentity;
    info.poseInReferenceSpace.position.y = INFINITY;
    EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_ERROR_POSE_INVALID);
    info.poseInReferenceSpace = kIdentity;
    info.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_UNBOUNDED_MSFT;
    EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_ERROR_REFERENCE_SPACE_UNSUPPORTED);
    info.referenceSpaceType = static_cast<XrReferenceSpaceType>(12345);
    EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_ERROR_REFERENCE_SPACE_UNSUPPORTED);
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    EXPECT_EQ(xrLocateSpace(stage_, stage_, 0, &location), XR_ERROR_TIME_INVALID);
    EXPECT_EQ(xrLocateSpace(stage_, XR_NULL_HANDLE, 1, &location), XR_ERROR_HANDLE_INVALID);
}

TEST_F(Space, TheLocalFloorIsBelowLocal) {
    setScript(kWalk);
    startSession();
    constexpr auto kLocalFloor = static_cast<XrReferenceSpaceType>(1000426000);
    EXPECT_TRUE(offers(kLocalFloor));
    const XrSpace local = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    const XrSpace floor = createSpace(kLocalFloor);
    const XrSpaceLocation in_local = locate(floor, local, 1);
    EXPECT_EQ(in_local.locationFlags, 15U);
    expectNear(in_local.pose.position, 0, -1.5F, 0);
    EXPECT_NEAR(in_local.pose.orientation.w, 1, 1e-6F);
    EXPECT_NEAR(locate(floor, stage_, 1).pose.position.y, 0, 1e-6F);
    XrExtent2Df bounds{9, 9};
    EXPECT_EQ(xrGetReferenceSpaceBoundsRect(session_, kLocalFloor, &bounds), XR_SPACE_BOUNDS_UNAVAILABLE);
    EXPECT_EQ(bounds.height, 0);
}

TEST_F(Space, TheLocalFloorNeedsItsExtension) {
    extensions_ = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
    startSession();
    constexpr auto kLocalFloor = static_cast<XrReferenceSpaceType>(1000426000);
    EXPECT_FALSE(offers(kLocalFloor));
    EXPECT_TRUE(offers(XR_REFERENCE_SPACE_TYPE_VIEW));
    EXPECT_TRUE(offers(XR_REFERENCE_SPACE_TYPE_LOCAL));
    EXPECT_TRUE(offers(XR_REFERENCE_SPACE_TYPE_STAGE));
    const XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, kLocalFloor,
                                          kIdentity};
    XrSpace space = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_ERROR_REFERENCE_SPACE_UNSUPPORTED);
    EXPECT_EQ(space, static_cast<XrSpace>(XR_NULL_HANDLE));
    XrExtent2Df bounds{};
    EXPECT_EQ(xrGetReferenceSpaceBoundsRect(session_, kLocalFloor, &bounds), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Space, OnlyTheStageHasBounds) {
    setScript(R"({"version": 1, "stage_bounds_m": [2.5, 4]})");
    startSession();
    XrExtent2Df bounds{9, 9};
    EXPECT_EQ(xrGetReferenceSpaceBoundsRect(session_, XR_REFERENCE_SPACE_TYPE_LOCAL, &bounds),
              XR_SPACE_BOUNDS_UNAVAILABLE);
    EXPECT_EQ(bounds.width, 0);
    ASSERT_EQ(xrGetReferenceSpaceBoundsRect(session_, XR_REFERENCE_SPACE_TYPE_STAGE, &bounds), XR_SUCCESS);
    EXPECT_EQ(bounds.width, 2.5F);
    EXPECT_EQ(bounds.height, 4);
    EXPECT_EQ(xrGetReferenceSpaceBoundsRect(session_, XR_REFERENCE_SPACE_TYPE_MAX_ENUM, &bounds),
              XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(xrGetReferenceSpaceBoundsRect(session_, XR_REFERENCE_SPACE_TYPE_STAGE, nullptr),
              XR_ERROR_VALIDATION_FAILURE);
}

}  // namespace
}  // namespace mock_test
