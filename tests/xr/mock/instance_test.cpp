#include <cstdio>
#include <cstring>
#include <string>

#include <openxr/openxr_reflection.h>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

class Instance : public MockTest {};

TEST_F(Instance, CanBeCreatedAndDestroyedRepeatedly) {
    for (int i = 0; i < 20; ++i) {
        start();
        auto properties = makeStruct<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
        ASSERT_EQ(xrGetInstanceProperties(instance_, &properties), XR_SUCCESS);
        EXPECT_STREQ(properties.runtimeName, "XR Mock");
        destroyInstance();
    }
}

TEST_F(Instance, OffersWholeExtensionsOnly) {
    const std::vector<std::string> names = offeredExtensions();
    EXPECT_NE(std::find(names.begin(), names.end(), "XR_KHR_vulkan_enable2"), names.end());
    EXPECT_NE(std::find(names.begin(), names.end(), "XR_EXT_debug_utils"), names.end());
}

TEST_F(Instance, RefusesAnApplicationWithoutName) {
    auto info = makeStruct<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    EXPECT_EQ(xrCreateInstance(&info, &instance_), XR_ERROR_NAME_INVALID);
    EXPECT_EQ(instance_, static_cast<XrInstance>(XR_NULL_HANDLE));
}

TEST_F(Instance, RefusesANewerApi) {
    auto info = makeStruct<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    std::strcpy(info.applicationInfo.applicationName, "newer");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 1, 0);
    EXPECT_EQ(xrCreateInstance(&info, &instance_), XR_ERROR_API_VERSION_UNSUPPORTED);
    EXPECT_EQ(instance_, static_cast<XrInstance>(XR_NULL_HANDLE));
}

TEST_F(Instance, ExtensionFunctionsNeedTheirExtension) {
    auto info = makeStruct<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    std::strcpy(info.applicationInfo.applicationName, "bare");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    ASSERT_EQ(xrCreateInstance(&info, &instance_), XR_SUCCESS);
    PFN_xrVoidFunction function = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrCreateVulkanInstanceKHR", &function),
              XR_ERROR_FUNCTION_UNSUPPORTED);
    EXPECT_EQ(function, nullptr);
    EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrNoSuchThing", &function), XR_ERROR_FUNCTION_UNSUPPORTED);
}

TEST_F(Instance, NamesResultsAndStructures) {
    start();
    char text[XR_MAX_RESULT_STRING_SIZE];
    ASSERT_EQ(xrResultToString(instance_, XR_ERROR_POSE_INVALID, text), XR_SUCCESS);
    EXPECT_STREQ(text, "XR_ERROR_POSE_INVALID");
    ASSERT_EQ(xrResultToString(instance_, static_cast<XrResult>(-123456), text), XR_SUCCESS);
    EXPECT_STREQ(text, "XR_UNKNOWN_FAILURE_-123456");
    ASSERT_EQ(xrResultToString(instance_, static_cast<XrResult>(123456), text), XR_SUCCESS);
    EXPECT_STREQ(text, "XR_UNKNOWN_SUCCESS_123456");
    char structure[XR_MAX_STRUCTURE_NAME_SIZE];
    ASSERT_EQ(xrStructureTypeToString(instance_, XR_TYPE_FRAME_END_INFO, structure), XR_SUCCESS);
    EXPECT_STREQ(structure, "XR_TYPE_FRAME_END_INFO");
    // Defined by hand, because the headers lack it.
    ASSERT_EQ(xrStructureTypeToString(instance_, static_cast<XrStructureType>(1000470001), structure),
              XR_SUCCESS);
    EXPECT_STREQ(structure, "XR_TYPE_SYSTEM_USER_PRESENCE_PROPERTIES_EXT");
    ASSERT_EQ(xrStructureTypeToString(instance_, static_cast<XrStructureType>(77777777), structure),
              XR_SUCCESS);
    EXPECT_STREQ(structure, "XR_UNKNOWN_STRUCTURE_TYPE_77777777");
}

TEST_F(Instance, NamesMatchTheHeaders) {
    start();
    char text[XR_MAX_RESULT_STRING_SIZE];
#define EXPECT_RESULT_NAME(name, value)                             \
    ASSERT_EQ(xrResultToString(instance_, name, text), XR_SUCCESS); \
    EXPECT_STREQ(text, #name);
    XR_LIST_ENUM_XrResult(EXPECT_RESULT_NAME)
#undef EXPECT_RESULT_NAME
        char structure[XR_MAX_STRUCTURE_NAME_SIZE];
#define EXPECT_TYPE_NAME(name, value)                                           \
    ASSERT_EQ(xrStructureTypeToString(instance_, name, structure), XR_SUCCESS); \
    EXPECT_STREQ(structure, #name);
    XR_LIST_ENUM_XrStructureType(EXPECT_TYPE_NAME)
#undef EXPECT_TYPE_NAME
        EXPECT_EQ(xrResultToString(instance_, XR_SUCCESS, nullptr), XR_ERROR_VALIDATION_FAILURE);
    EXPECT_EQ(xrStructureTypeToString(instance_, XR_TYPE_UNKNOWN, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Instance, PathsRoundTrip) {
    start();
    const std::string longest = "/" + std::string(XR_MAX_PATH_LENGTH - 2, 'a');
    for (const std::string& text :
         {std::string("/a"), std::string("/user/hand/left"), std::string("/a-b_c.9/.x"), longest}) {
        const XrPath atom = path(text.c_str());
        EXPECT_EQ(atom, path(text.c_str()));
        std::uint32_t count = 0;
        ASSERT_EQ(xrPathToString(instance_, atom, 0, &count, nullptr), XR_SUCCESS);
        ASSERT_EQ(count, text.size() + 1);
        std::string back(count, '?');
        EXPECT_EQ(xrPathToString(instance_, atom, count - 1, &count, back.data()),
                  XR_ERROR_SIZE_INSUFFICIENT);
        EXPECT_EQ(count, text.size() + 1);
        EXPECT_EQ(back, std::string(count, '?'));
        ASSERT_EQ(xrPathToString(instance_, atom, count, &count, back.data()), XR_SUCCESS);
        EXPECT_STREQ(back.c_str(), text.c_str());
    }
}

TEST_F(Instance, RefusesMalformedPaths) {
    start();
    const std::string too_long = "/" + std::string(XR_MAX_PATH_LENGTH - 1, 'a');
    XrPath atom;
    for (const std::string& text :
         {std::string(), std::string("/"), std::string("a"), std::string("/a/"), std::string("//a"),
          std::string("/A"), std::string("/a b"), std::string("/.."), std::string("/a/./b"),
          std::string("/a/\xc3\xa9"), too_long}) {
        EXPECT_EQ(xrStringToPath(instance_, text.c_str(), &atom), XR_ERROR_PATH_FORMAT_INVALID) << text;
    }
    std::uint32_t count;
    EXPECT_EQ(xrPathToString(instance_, XR_NULL_PATH, 0, &count, nullptr), XR_ERROR_PATH_INVALID);
    EXPECT_EQ(xrPathToString(instance_, 999, 0, &count, nullptr), XR_ERROR_PATH_INVALID);
}

TEST_F(Instance, DescribesOneStereoSystem) {
    setScript(R"({"version": 1, "eyes": {"recommended_size": [320, 200]}})");
    start();
    XrSystemId other;
    XrSystemGetInfo get_info{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HANDHELD_DISPLAY};
    EXPECT_EQ(xrGetSystem(instance_, &get_info, &other), XR_ERROR_FORM_FACTOR_UNSUPPORTED);
    get_info.formFactor = static_cast<XrFormFactor>(99);
    EXPECT_EQ(xrGetSystem(instance_, &get_info, &other), XR_ERROR_FORM_FACTOR_UNSUPPORTED);
    auto properties = makeStruct<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    EXPECT_EQ(xrGetSystemProperties(instance_, system_ + 1, &properties), XR_ERROR_SYSTEM_INVALID);
    ASSERT_EQ(xrGetSystemProperties(instance_, system_, &properties), XR_SUCCESS);
    EXPECT_GE(properties.graphicsProperties.maxLayerCount,
              std::uint32_t{XR_MIN_COMPOSITION_LAYERS_SUPPORTED});

    std::uint32_t count = 0;
    std::array<XrViewConfigurationView, 2> views{};
    views.fill({XR_TYPE_VIEW_CONFIGURATION_VIEW, nullptr, 0, 0, 0, 0, 0, 0});
    EXPECT_EQ(xrEnumerateViewConfigurationViews(instance_, system_, kStereo, 1, &count, views.data()),
              XR_ERROR_SIZE_INSUFFICIENT);
    ASSERT_EQ(count, 2U);
    ASSERT_EQ(xrEnumerateViewConfigurationViews(instance_, system_, kStereo, 2, &count, views.data()),
              XR_SUCCESS);
    EXPECT_EQ(views[1].recommendedImageRectWidth, 320U);
    EXPECT_EQ(views[1].recommendedImageRectHeight, 200U);
    EXPECT_EQ(xrEnumerateViewConfigurationViews(instance_, system_, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_MONO,
                                                0, &count, nullptr),
              XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
    XrViewConfigurationProperties stereo{XR_TYPE_VIEW_CONFIGURATION_PROPERTIES, nullptr, kStereo, XR_TRUE};
    EXPECT_EQ(xrGetViewConfigurationProperties(instance_, system_, kStereo, &stereo), XR_SUCCESS);
    EXPECT_EQ(stereo.fovMutable, XrBool32{XR_FALSE});
    EXPECT_EQ(
        xrGetViewConfigurationProperties(instance_, system_, XR_VIEW_CONFIGURATION_TYPE_MAX_ENUM, &stereo),
        XR_ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED);
    EXPECT_EQ(xrEnumerateViewConfigurationViews(instance_, system_, kStereo, 2, nullptr, views.data()),
              XR_ERROR_VALIDATION_FAILURE);
    XrEnvironmentBlendMode mode;
    ASSERT_EQ(xrEnumerateEnvironmentBlendModes(instance_, system_, kStereo, 1, &count, &mode), XR_SUCCESS);
    EXPECT_EQ(mode, XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
}

TEST_F(Instance, ChecksStructureTypes) {
    start();
    auto event = makeStruct<XrEventDataBuffer>(XR_TYPE_FRAME_STATE);
    EXPECT_EQ(xrPollEvent(instance_, &event), XR_ERROR_VALIDATION_FAILURE);
    event.type = XR_TYPE_EVENT_DATA_BUFFER;
    EXPECT_EQ(xrPollEvent(instance_, &event), XR_EVENT_UNAVAILABLE);
}

TEST_F(Instance, RefusesDeadAndForeignHandles) {
    startSession();
    XrSpace space = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    ASSERT_EQ(xrDestroySpace(space), XR_SUCCESS);
    EXPECT_EQ(xrDestroySpace(space), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(xrDestroySpace(reinterpret_cast<XrSpace>(session_)), XR_ERROR_HANDLE_INVALID);
    const XrSpace reused = createSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    EXPECT_NE(reused, space);
    const XrSwapchain swapchain = createSwapchain(swapchainInfo()).handle;
    ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
    EXPECT_EQ(xrDestroySpace(reused), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(xrDestroySwapchain(swapchain), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(xrDestroySession(session_), XR_ERROR_HANDLE_INVALID);
}

}  // namespace
}  // namespace mock_test
