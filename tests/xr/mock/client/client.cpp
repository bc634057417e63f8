#include "tests/xr/mock/client/client.h"

#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

#include "xr/mock/scenario/loader_interface.h"

#ifdef STYLET_SANITIZED
// These libraries synchronize with atomics that ThreadSanitizer cannot see.
extern "C" const char* __tsan_default_suppressions() {
    return "race:libVkLayer_khronos_validation.so\nrace:libvulkan_lvp.so\n";
}
#endif

namespace mock_test {

namespace {

VKAPI_ATTR VkBool32 VKAPI_CALL note(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                    const VkDebugUtilsMessengerCallbackDataEXT* data, void* messages) {
    static_cast<std::vector<std::string>*>(messages)->push_back(data->pMessage);
    return VK_FALSE;
}

bool hasValidationLayer() {
    std::uint32_t count = 0;
    vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
        return std::strcmp(layer.layerName, "VK_LAYER_KHRONOS_validation") == 0;
    });
}

}  // namespace

std::vector<std::string> offeredExtensions() {
    std::uint32_t count = 0;
    EXPECT_EQ(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr), XR_SUCCESS);
    std::vector<XrExtensionProperties> extensions(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, "", 0});
    EXPECT_EQ(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, extensions.data()), XR_SUCCESS);
    std::vector<std::string> names;
    for (const auto& extension : extensions)
        names.emplace_back(extension.extensionName);
    return names;
}

PFN_xrGetInstanceProcAddr runtimeEntry() {
    const char* manifest = std::getenv("XR_RUNTIME_JSON");
    if (manifest == nullptr) return nullptr;
    const auto path = std::filesystem::path(manifest).replace_filename("libxrmock.so");
    void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return nullptr;
    const auto negotiate = reinterpret_cast<decltype(&xrNegotiateLoaderRuntimeInterface)>(
        dlsym(library, "xrNegotiateLoaderRuntimeInterface"));
    const XrNegotiateLoaderInfo loader{XR_LOADER_INTERFACE_STRUCT_LOADER_INFO,
                                       kLoaderStructVersion,
                                       sizeof(XrNegotiateLoaderInfo),
                                       1,
                                       1,
                                       XR_MAKE_VERSION(1, 0, 0),
                                       XR_MAKE_VERSION(1, 0x3ff, 0xfff)};
    XrNegotiateRuntimeRequest request{XR_LOADER_INTERFACE_STRUCT_RUNTIME_REQUEST,
                                      kLoaderStructVersion,
                                      sizeof(XrNegotiateRuntimeRequest),
                                      0,
                                      0,
                                      nullptr};
    return negotiate(&loader, &request) == XR_SUCCESS ? request.getInstanceProcAddr : nullptr;
}

void waitUntilAsleep(const std::atomic<int>& thread) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < deadline) {
        std::ifstream in("/proc/self/task/" + std::to_string(thread.load()) + "/stat");
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        const std::size_t name_end = text.rfind(") ");
        if (name_end != std::string::npos && text.at(name_end + 2) == 'S') return;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    throw std::runtime_error("the thread does not sleep");
}

void MockTest::SetUp() {
    setVariable("XRMOCK_CLOCK", "virtual");
    setVariable("XRMOCK_CAPTURE", folder_.path().string());
}

void MockTest::TearDown() {
    destroyAll();
    for (const std::string& name : variables_)
        unsetenv(name.c_str());
    for (const std::string& message : vk_messages_)
        ADD_FAILURE() << message;
}

void MockTest::destroyAll() {
    if (vk_device_ != VK_NULL_HANDLE) vkDeviceWaitIdle(vk_device_);
    if (instance_ != XR_NULL_HANDLE) destroyInstance();
    if (vk_device_ != VK_NULL_HANDLE) vkDestroyDevice(vk_device_, nullptr);
    vk_device_ = VK_NULL_HANDLE;
    destroyVulkanInstance();
}

void MockTest::destroyVulkanInstance() {
    if (vk_messenger_ != VK_NULL_HANDLE) {
        reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(vkGetInstanceProcAddr(
            vk_instance_, "vkDestroyDebugUtilsMessengerEXT"))(vk_instance_, vk_messenger_, nullptr);
    }
    if (vk_instance_ != VK_NULL_HANDLE) vkDestroyInstance(vk_instance_, nullptr);
    vk_messenger_ = VK_NULL_HANDLE;
    vk_instance_ = VK_NULL_HANDLE;
}

void MockTest::setVariable(const std::string& name, const std::string& value) {
    setenv(name.c_str(), value.c_str(), 1);
    variables_.push_back(name);
}

void MockTest::setScript(const std::string& text) {
    std::ofstream(file("scenario.json")) << text;
    setVariable("XRMOCK_SCENARIO", file("scenario.json").string());
}

XrResult MockTest::tryInstance(const void* next) {
    const std::vector<std::string> names = extensions_.empty() ? offeredExtensions() : extensions_;
    std::vector<const char*> extensions;
    for (const std::string& name : names)
        extensions.push_back(name.c_str());
    auto info = makeStruct<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    info.next = next;
    std::strcpy(info.applicationInfo.applicationName, "mock test");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.enabledExtensionNames = extensions.data();
    return xrCreateInstance(&info, &instance_);
}

void MockTest::destroyInstance() {
    EXPECT_EQ(xrDestroyInstance(instance_), XR_SUCCESS);
    instance_ = XR_NULL_HANDLE;
}

void MockTest::start() {
    ASSERT_EQ(tryInstance(), XR_SUCCESS);
    const XrSystemGetInfo info{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    ASSERT_EQ(xrGetSystem(instance_, &info, &system_), XR_SUCCESS);
}

void MockTest::startVulkan() {
    start();
    auto requirements =
        makeStruct<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
    ASSERT_EQ(load<PFN_xrGetVulkanGraphicsRequirements2KHR>(instance_, "xrGetVulkanGraphicsRequirements2KHR")(
                  instance_, system_, &requirements),
              XR_SUCCESS);

    const VkApplicationInfo application{
        VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "mock test", 1, nullptr, 0, VK_API_VERSION_1_1};
    const VkValidationFeatureEnableEXT synchronization =
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT features{
        VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, nullptr, 1, &synchronization, 0, nullptr};
    const char* layer = "VK_LAYER_KHRONOS_validation";
    const char* debug = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    VkInstanceCreateInfo instance_info{};
    instance_info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    instance_info.pApplicationInfo = &application;
    const bool validated = validated_ && hasValidationLayer();
    if (validated) {
        instance_info.pNext = &features;
        instance_info.enabledLayerCount = 1;
        instance_info.ppEnabledLayerNames = &layer;
        instance_info.enabledExtensionCount = 1;
        instance_info.ppEnabledExtensionNames = &debug;
    }
    auto xr_instance_info =
        makeStruct<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
    xr_instance_info.systemId = system_;
    xr_instance_info.pfnGetInstanceProcAddr = vkGetInstanceProcAddr;
    xr_instance_info.vulkanCreateInfo = &instance_info;
    VkResult result = VK_ERROR_UNKNOWN;
    ASSERT_EQ(load<PFN_xrCreateVulkanInstanceKHR>(instance_, "xrCreateVulkanInstanceKHR")(
                  instance_, &xr_instance_info, &vk_instance_, &result),
              XR_SUCCESS);
    ASSERT_EQ(result, VK_SUCCESS);
    if (validated) {
        const VkDebugUtilsMessengerCreateInfoEXT messenger_info{
            VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
            nullptr,
            0,
            VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
            VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
            note,
            &vk_messages_};
        reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
            vkGetInstanceProcAddr(vk_instance_, "vkCreateDebugUtilsMessengerEXT"))(
            vk_instance_, &messenger_info, nullptr, &vk_messenger_);
    }

    const XrVulkanGraphicsDeviceGetInfoKHR device_get_info{XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR,
                                                           nullptr, system_, vk_instance_};
    ASSERT_EQ(load<PFN_xrGetVulkanGraphicsDevice2KHR>(instance_, "xrGetVulkanGraphicsDevice2KHR")(
                  instance_, &device_get_info, &vk_physical_device_),
              XR_SUCCESS);
    const float priority = 1;
    VkDeviceQueueCreateInfo queue_info{};
    queue_info.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue_info.queueFamilyIndex = vk_queue_family_;
    queue_info.queueCount = 1;
    queue_info.pQueuePriorities = &priority;
    VkDeviceCreateInfo device_info{};
    device_info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    device_info.queueCreateInfoCount = 1;
    device_info.pQueueCreateInfos = &queue_info;
    auto xr_device_info = makeStruct<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
    xr_device_info.systemId = system_;
    xr_device_info.pfnGetInstanceProcAddr = vkGetInstanceProcAddr;
    xr_device_info.vulkanPhysicalDevice = vk_physical_device_;
    xr_device_info.vulkanCreateInfo = &device_info;
    ASSERT_EQ(load<PFN_xrCreateVulkanDeviceKHR>(instance_, "xrCreateVulkanDeviceKHR")(
                  instance_, &xr_device_info, &vk_device_, &result),
              XR_SUCCESS);
    ASSERT_EQ(result, VK_SUCCESS);
    vkGetDeviceQueue(vk_device_, vk_queue_family_, 0, &vk_queue_);
}

XrGraphicsBindingVulkan2KHR MockTest::binding() const {
    return {XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR,
            nullptr,
            vk_instance_,
            vk_physical_device_,
            vk_device_,
            vk_queue_family_,
            0};
}

XrResult MockTest::trySession(const void* binding, XrSession* session) {
    const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, binding, 0, system_};
    return xrCreateSession(instance_, &info, session);
}

void MockTest::startSession() {
    startVulkan();
    const XrGraphicsBindingVulkan2KHR graphics = binding();
    ASSERT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
    stage_ = createSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
}

void MockTest::startRunning() {
    startSession();
    ASSERT_EQ(beginSession(), XR_SUCCESS);
}

XrResult MockTest::beginSession() {
    const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, kStereo};
    return xrBeginSession(session_, &info);
}

void MockTest::startFocused() {
    startRunning();
    for (int i = 0; i < 3; ++i)
        frame();
    ASSERT_EQ(states().back(), XR_SESSION_STATE_FOCUSED);
}

std::optional<XrEventDataBuffer> MockTest::poll(XrStructureType type) {
    auto event = makeStruct<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    while (xrPollEvent(instance_, &event) == XR_SUCCESS) {
        if (event.type == type) return event;
        event.type = XR_TYPE_EVENT_DATA_BUFFER;
    }
    return std::nullopt;
}

std::vector<XrSessionState> MockTest::states() {
    std::vector<XrSessionState> found;
    while (const auto event = poll(XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)) {
        XrEventDataSessionStateChanged changed;
        std::memcpy(&changed, &*event, sizeof changed);
        EXPECT_EQ(changed.session, session_);
        EXPECT_GT(changed.time, 0);
        found.push_back(changed.state);
    }
    return found;
}

XrResult MockTest::waitFrame(XrFrameState* state) {
    auto unused = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    const XrFrameWaitInfo info{XR_TYPE_FRAME_WAIT_INFO, nullptr};
    return xrWaitFrame(session_, &info, state == nullptr ? &unused : state);
}

XrResult MockTest::beginFrame() {
    const XrFrameBeginInfo info{XR_TYPE_FRAME_BEGIN_INFO, nullptr};
    return xrBeginFrame(session_, &info);
}

XrResult MockTest::endFrame(XrTime time, const std::vector<const XrCompositionLayerBaseHeader*>& layers) {
    const XrFrameEndInfo info{XR_TYPE_FRAME_END_INFO,
                              nullptr,
                              time,
                              XR_ENVIRONMENT_BLEND_MODE_OPAQUE,
                              static_cast<std::uint32_t>(layers.size()),
                              layers.data()};
    return xrEndFrame(session_, &info);
}

XrFrameState MockTest::frame(const std::vector<const XrCompositionLayerBaseHeader*>& layers) {
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    EXPECT_EQ(waitFrame(&state), XR_SUCCESS);
    EXPECT_EQ(beginFrame(), XR_SUCCESS);
    EXPECT_EQ(endFrame(state.predictedDisplayTime, layers), XR_SUCCESS);
    return state;
}

XrResult MockTest::tryFrame(const std::vector<const XrCompositionLayerBaseHeader*>& layers) {
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    EXPECT_EQ(waitFrame(&state), XR_SUCCESS);
    EXPECT_EQ(beginFrame(), XR_SUCCESS);
    const XrResult result = endFrame(state.predictedDisplayTime, layers);
    if (result != XR_SUCCESS) {
        EXPECT_EQ(endFrame(state.predictedDisplayTime), XR_SUCCESS);
    }
    return result;
}

void MockTest::projectionFrame(const XrSwapchainSubImage& left, const XrSwapchainSubImage& right,
                               float aside_m) {
    auto state = makeStruct<XrFrameState>(XR_TYPE_FRAME_STATE);
    ASSERT_EQ(waitFrame(&state), XR_SUCCESS);
    ASSERT_EQ(beginFrame(), XR_SUCCESS);
    std::array<XrView, 2> located;
    located.fill({XR_TYPE_VIEW, nullptr, kIdentity, {-0.5F, 0.5F, 0.5F, -0.5F}});
    tryLocateViews(stage_, state.predictedDisplayTime, located);
    std::array<XrCompositionLayerProjectionView, 2> views;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        located[eye].pose.position.x += aside_m;
        views[eye] = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, located[eye].pose, located[eye].fov,
                      eye == 0 ? left : right};
    }
    const XrCompositionLayerProjection layer{
        XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, stage_, 2, views.data()};
    ASSERT_EQ(endFrame(state.predictedDisplayTime, {header(layer)}), XR_SUCCESS);
}

void MockTest::projectionFrame(const Swapchain& swapchain, float aside_m) {
    cycle(swapchain.handle);
    projectionFrame(whole(swapchain, 0), whole(swapchain, 1), aside_m);
}

XrResult MockTest::tryLocateViews(XrSpace space, XrTime time, std::array<XrView, 2>& views) {
    const XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO, nullptr, kStereo, time, space};
    auto state = makeStruct<XrViewState>(XR_TYPE_VIEW_STATE);
    std::uint32_t count = 0;
    return xrLocateViews(session_, &info, &state, 2, &count, views.data());
}

std::array<XrView, 2> MockTest::locateViews(XrSpace space, XrTime time) {
    std::array<XrView, 2> views{makeStruct<XrView>(XR_TYPE_VIEW), makeStruct<XrView>(XR_TYPE_VIEW)};
    EXPECT_EQ(tryLocateViews(space, time, views), XR_SUCCESS);
    return views;
}

XrSpaceLocation MockTest::locate(XrSpace space, XrSpace base, XrTime time, XrSpaceVelocity* velocity) {
    auto location = makeStruct<XrSpaceLocation>(XR_TYPE_SPACE_LOCATION);
    location.next = velocity;
    EXPECT_EQ(xrLocateSpace(space, base, time, &location), XR_SUCCESS);
    return location;
}

std::vector<std::int64_t> MockTest::swapchainFormats() {
    std::uint32_t count = 0;
    EXPECT_EQ(xrEnumerateSwapchainFormats(session_, 0, &count, nullptr), XR_SUCCESS);
    std::vector<std::int64_t> formats(count);
    EXPECT_EQ(xrEnumerateSwapchainFormats(session_, count, &count, formats.data()), XR_SUCCESS);
    return formats;
}

XrSwapchainSubImage whole(const Swapchain& swapchain, std::uint32_t layer) {
    return {swapchain.handle,
            {{0, 0}, {static_cast<int>(swapchain.width), static_cast<int>(swapchain.height)}},
            layer};
}

XrCompositionLayerQuad quadLayer(XrSpace space, const Swapchain& swapchain, XrPosef pose,
                                 XrExtent2Df size_m) {
    return {XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr,          0,    space,
            XR_EYE_VISIBILITY_BOTH,         whole(swapchain), pose, size_m};
}

XrSwapchainCreateInfo MockTest::swapchainInfo() const {
    auto info = makeStruct<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT;
    info.format = VK_FORMAT_R8G8B8A8_SRGB;
    info.sampleCount = 1;
    info.width = 64;
    info.height = 48;
    info.faceCount = 1;
    info.arraySize = 2;
    info.mipCount = 1;
    return info;
}

Swapchain MockTest::createSwapchain(const XrSwapchainCreateInfo& info) {
    Swapchain swapchain{XR_NULL_HANDLE, {}, info.width, info.height};
    EXPECT_EQ(xrCreateSwapchain(session_, &info, &swapchain.handle), XR_SUCCESS);
    std::uint32_t count = 0;
    EXPECT_EQ(xrEnumerateSwapchainImages(swapchain.handle, 0, &count, nullptr), XR_SUCCESS);
    std::vector<XrSwapchainImageVulkan2KHR> images(
        count, makeStruct<XrSwapchainImageVulkan2KHR>(XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR));
    EXPECT_EQ(xrEnumerateSwapchainImages(swapchain.handle, count, &count,
                                         reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data())),
              XR_SUCCESS);
    for (const auto& image : images)
        swapchain.images.push_back(image.image);
    return swapchain;
}

std::uint32_t MockTest::acquireAndWait(XrSwapchain swapchain) {
    std::uint32_t index = 0;
    EXPECT_EQ(xrAcquireSwapchainImage(swapchain, nullptr, &index), XR_SUCCESS);
    const XrSwapchainImageWaitInfo info{XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO, nullptr, XR_INFINITE_DURATION};
    EXPECT_EQ(xrWaitSwapchainImage(swapchain, &info), XR_SUCCESS);
    return index;
}

void MockTest::cycle(XrSwapchain swapchain) {
    acquireAndWait(swapchain);
    EXPECT_EQ(xrReleaseSwapchainImage(swapchain, nullptr), XR_SUCCESS);
}

XrSpace MockTest::createSpace(XrReferenceSpaceType type, XrPosef pose) {
    const XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, type, pose};
    XrSpace space = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateReferenceSpace(session_, &info, &space), XR_SUCCESS);
    return space;
}

XrPath MockTest::path(const char* text) {
    XrPath atom = XR_NULL_PATH;
    EXPECT_EQ(xrStringToPath(instance_, text, &atom), XR_SUCCESS) << text;
    return atom;
}

}  // namespace mock_test
