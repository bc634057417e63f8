// Features that depend on scenario and environment: blend modes, spaces, formats, extensions. Also tests
// stalled calls.
#include <chrono>
#include <fstream>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

constexpr auto kStationary = static_cast<XrReferenceSpaceType>(1000742000);
constexpr auto kGenerationResult = static_cast<XrStructureType>(1000742002);

struct Generation {
    XrStructureType type = kGenerationResult;
    void* next = nullptr;
    std::array<std::uint8_t, 16> id{};
};

class Offers : public MockTest {
  protected:
    Generation generation() {
        Generation result;
        PFN_xrVoidFunction found = nullptr;
        EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrGetStationaryReferenceSpaceGenerationIdEXT", &found),
                  XR_SUCCESS);
        using Get = XrResult(XRAPI_PTR*)(XrSession, const void*, Generation*);
        got_ = reinterpret_cast<Get>(found)(session_, nullptr, &result);
        return result;
    }
    XrResult got_ = XR_SUCCESS;
};

TEST_F(Offers, BlendModesAreThoseOfTheScenario) {
    setScript(R"({"version": 2, "offers": {"blend_modes": ["alpha_blend", "opaque"]}})");
    startFocused();
    std::array<XrEnvironmentBlendMode, 3> modes{};
    std::uint32_t count = 0;
    ASSERT_EQ(xrEnumerateEnvironmentBlendModes(instance_, system_, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                                               3, &count, modes.data()),
              XR_SUCCESS);
    EXPECT_EQ(count, 2u);
    EXPECT_EQ(modes[0], XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND);
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    XrFrameEndInfo info{XR_TYPE_FRAME_END_INFO,
                        nullptr,
                        state.predictedDisplayTime,
                        XR_ENVIRONMENT_BLEND_MODE_ADDITIVE,
                        0,
                        nullptr};
    EXPECT_EQ(xrEndFrame(session_, &info), XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED);
    info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND;
    EXPECT_EQ(xrEndFrame(session_, &info), XR_SUCCESS);
}

TEST_F(Offers, AStationarySpaceKeepsItsGenerationUntilItIsLost) {
    setScript(R"({"version": 2, "offers": {"spaces": ["stage", "stationary"]}, "events": [
        {"frame": 6, "recenter": {"space": "stage"}},
        {"frame": 8, "recenter": {"space": "stationary", "pose": {"position": [1, 0, 0]}}}]})");
    startFocused();
    const XrSpace space = createSpace(kStationary);
    const Generation first = generation();
    EXPECT_EQ(got_, XR_SUCCESS);
    frame(), frame(), frame();
    EXPECT_EQ(generation().id, first.id);
    for (int i = 0; i < 4; ++i)
        frame();
    EXPECT_NE(generation().id, first.id);
    int told = 0;
    while (const auto event = poll(XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING)) {
        const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(*event);
        if (change.referenceSpaceType != kStationary) continue;
        ++told;
        EXPECT_FLOAT_EQ(change.poseInPreviousSpace.position.x, 1.0f);
    }
    EXPECT_EQ(told, 1);
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    const XrSpace stage = createSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
    ASSERT_EQ(xrLocateSpace(space, stage, frame().predictedDisplayTime, &location), XR_SUCCESS);
    EXPECT_NE(location.locationFlags, 0u);
}

TEST_F(Offers, SpacesThatAreNotOfferedAreRefused) {
    setScript(R"({"version": 2, "offers": {"spaces": []}})");
    startVulkan();
    ASSERT_EQ(trySession(nullptr, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    const XrGraphicsBindingVulkan2KHR given = binding();
    ASSERT_EQ(trySession(&given, &session_), XR_SUCCESS);
    for (const auto type : {XR_REFERENCE_SPACE_TYPE_STAGE, kStationary}) {
        XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, type, kIdentity};
        XrSpace space = XR_NULL_HANDLE;
        EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_ERROR_REFERENCE_SPACE_UNSUPPORTED);
    }
    generation();
    EXPECT_EQ(got_, XR_ERROR_REFERENCE_SPACE_UNSUPPORTED);
}

TEST_F(Offers, FormatsAreThoseOfTheScenario) {
    setScript(R"({"version": 2, "offers": {"formats": [37, 126]}})");
    startSession();
    std::array<std::int64_t, 8> formats{};
    std::uint32_t count = 0;
    ASSERT_EQ(xrEnumerateSwapchainFormats(session_, 8, &count, formats.data()), XR_SUCCESS);
    ASSERT_EQ(count, 2u);
    EXPECT_EQ(formats[0], VK_FORMAT_R8G8B8A8_UNORM);
    XrSwapchainCreateInfo info = swapchainInfo();
    info.format = VK_FORMAT_R8G8B8A8_SRGB;
    XrSwapchain swapchain = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateSwapchain(session_, &info, &swapchain), XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED);
}

TEST_F(Offers, ExtensionsMayBeWithheldOrRefused) {
    const auto offers = [](const char* name) {
        std::uint32_t count = 0;
        EXPECT_EQ(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr), XR_SUCCESS);
        std::vector<XrExtensionProperties> all(
            count, makeStruct<XrExtensionProperties>(XR_TYPE_EXTENSION_PROPERTIES));
        EXPECT_EQ(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, all.data()), XR_SUCCESS);
        return std::any_of(all.begin(), all.end(),
                           [&](const auto& each) { return std::string(each.extensionName) == name; });
    };
    EXPECT_TRUE(offers("XR_EXT_local_floor"));
    setVariable("XRMOCK_WITHHOLD", "XR_EXT_palm_pose XR_EXT_local_floor");
    EXPECT_FALSE(offers("XR_EXT_local_floor"));
    EXPECT_FALSE(offers("XR_EXT_palm_pose"));
    setVariable("XRMOCK_WITHHOLD", "!XR_EXT_local_floor");
    EXPECT_TRUE(offers("XR_EXT_local_floor"));
    extensions_ = {"XR_EXT_local_floor"};
    EXPECT_EQ(tryInstance(), XR_ERROR_EXTENSION_NOT_PRESENT);
}

TEST_F(Offers, ARefusalAtTimeZeroAppliesToTheFirstCalls) {
    setScript(R"({"version": 2, "events": [
        {"t_s": 0, "refuse": {"call": "xrGetSystem", "result": "XR_ERROR_FORM_FACTOR_UNAVAILABLE"}}]})");
    ASSERT_EQ(tryInstance(), XR_SUCCESS);
    const XrSystemGetInfo info{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    XrSystemId system = XR_NULL_SYSTEM_ID;
    EXPECT_EQ(xrGetSystem(instance_, &info, &system), XR_ERROR_FORM_FACTOR_UNAVAILABLE);
    EXPECT_EQ(xrGetSystem(instance_, &info, &system), XR_SUCCESS);
}

TEST_F(Offers, AStalledCallIsDelayed) {
    setScript(
        R"({"version": 2, "events": [{"frame": 2, "stall": {"call": "xrLocateViews", "for_s": 0.2, "nth": 2}}]})");
    startFocused();
    const auto measureSeconds = [&] {
        const auto begin = std::chrono::steady_clock::now();
        locateViews(stage_, frame().predictedDisplayTime);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    };
    measureSeconds();
    EXPECT_GE(measureSeconds(), 0.2);
}

TEST_F(Offers, UnknownValuesAreRefused) {
    const std::pair<const char*, const char*> kBad[] = {
        {R"("offers": {"blend_modes": []})", "offers.blend_modes: at least one mode expected"},
        {R"("offers": {"blend_modes": ["glass"]})", "offers.blend_modes[0]"},
        {R"("offers": {"spaces": ["moon"]})", "offers.spaces[0]"},
        {R"("offers": {"formats": [0]})", "offers.formats[0]"},
        {R"("offers": {"sound": true})", "offers.sound: unknown field"},
        {R"("events": [{"t_s": 0, "stall": {"call": "xrFly", "for_s": 1}}])", "events[0].stall.call"},
        {R"("events": [{"t_s": 0, "stall": {"call": "xrEndFrame", "for_s": 11}}])", "events[0].stall.for_s"},
        {R"("events": [{"t_s": 0, "stall": {"call": "xrEndFrame"}}])", "for_s"}};
    for (const auto& [fields, reason] : kBad) {
        setScript(R"({"version": 2, )" + std::string(fields) + "}");
        testing::internal::CaptureStderr();
        EXPECT_NE(tryInstance(), XR_SUCCESS) << fields;
        EXPECT_NE(testing::internal::GetCapturedStderr().find(reason), std::string::npos) << fields;
    }
    setScript(R"({"version": 1, "offers": {}})");
    testing::internal::CaptureStderr();
    EXPECT_NE(tryInstance(), XR_SUCCESS);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("only version 2 has this field"),
              std::string::npos);
}

}  // namespace
}  // namespace mock_test
