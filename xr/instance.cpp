#include "xr/instance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <type_traits>

namespace stylet::xr {
namespace {

std::string noRuntime() {
    return fmt::format(
        "no OpenXR runtime could be reached; looked at {}; start the headset's runtime, or set "
        "XR_RUNTIME_JSON to its manifest",
        fmt::join(runtimeSearchPath(), ", "));
}

std::vector<XrExtensionProperties> offeredExtensions() {
    return enumerate<XrExtensionProperties>(
        "xrEnumerateInstanceExtensionProperties", noRuntime(),
        [](auto... out) { return xrEnumerateInstanceExtensionProperties(nullptr, out...); },
        {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
}

// In the order of the request. Only the first is required.
constexpr const char* kWanted[] = {
    XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME,
    XR_EXT_DEBUG_UTILS_EXTENSION_NAME,
    XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME,
    XR_KHR_VISIBILITY_MASK_EXTENSION_NAME,
    XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
    XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME,
    XR_EXT_USER_PRESENCE_EXTENSION_NAME,
    XR_EXT_UUID_EXTENSION_NAME,
    XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME,
    XR_EXT_LOCAL_FLOOR_EXTENSION_NAME,
    XR_EXT_HAND_TRACKING_EXTENSION_NAME,
    XR_EXT_HP_MIXED_REALITY_CONTROLLER_EXTENSION_NAME,
    XR_HTC_VIVE_FOCUS3_CONTROLLER_INTERACTION_EXTENSION_NAME,
    XR_BD_CONTROLLER_INTERACTION_EXTENSION_NAME,
    XR_FB_TOUCH_CONTROLLER_PRO_EXTENSION_NAME,
    XR_META_TOUCH_CONTROLLER_PLUS_EXTENSION_NAME,
};

bool offers(const std::vector<XrExtensionProperties>& offered, const char* name) {
    return std::any_of(offered.begin(), offered.end(),
                       [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

template <typename Function>
Function find(XrInstance instance, const char* name) {
    PFN_xrVoidFunction function = nullptr;
    check(xrGetInstanceProcAddr(instance, name, &function), name,
          "the runtime lacks a function of an extension that it offers");
    return reinterpret_cast<Function>(function);
}

std::string versionText(std::uint32_t major_minor) {
    return fmt::format("{}.{}", major_minor >> 16, major_minor & 0xffff);
}

}  // namespace

Instance::Instance(const std::string& application_name, std::vector<std::string>& notes) {
    create(application_name, notes);
    findCalls(notes);
    findSystem();
    readGraphicsRequirements();
}

bool Instance::has(std::string_view extension) const {
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

void Instance::create(const std::string& application_name, std::vector<std::string>& notes) {
    const auto offered = offeredExtensions();
    if (!offers(offered, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME))
        throw XrError("xrEnumerateInstanceExtensionProperties: the OpenXR runtime does not offer " +
                      std::string(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME) +
                      ": it cannot show pictures made with Vulkan");
    std::vector<const char*> wanted;
    std::copy_if(std::begin(kWanted), std::end(kWanted), std::back_inserter(wanted),
                 [&](const char* name) { return offers(offered, name); });

    auto info = makeStruct<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    application_name.copy(info.applicationInfo.applicationName, XR_MAX_APPLICATION_NAME_SIZE - 1);
    std::string("Stylet").copy(info.applicationInfo.engineName, XR_MAX_ENGINE_NAME_SIZE - 1);
    // Debian's loader refuses 1.1.
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = std::uint32_t(wanted.size());
    info.enabledExtensionNames = wanted.data();
    XrResult made = xrCreateInstance(&info, handle.out());
    if (made == XR_ERROR_EXTENSION_NOT_PRESENT) {
        notes.push_back(
            "xrCreateInstance: " + resultName(made) +
            ": the runtime refuses an extension that it offers: only XR_KHR_vulkan_enable2 is requested now");
        wanted.resize(1);
        info.enabledExtensionCount = 1;
        made = xrCreateInstance(&info, handle.out());
    }
    check(made, "xrCreateInstance", noRuntime());
    extensions.assign(wanted.begin(), wanted.end());

    auto properties = makeStruct<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
    check(xrGetInstanceProperties(handle.get(), &properties), "xrGetInstanceProperties",
          "the OpenXR runtime does not report its name");
    runtime_name = properties.runtimeName;
    const XrVersion version = properties.runtimeVersion;
    runtime_version = fmt::format("{}.{}.{}", XR_VERSION_MAJOR(version), XR_VERSION_MINOR(version),
                                  XR_VERSION_PATCH(version));
}

// Looks up the extension functions. If one is missing, its extension is removed from the granted ones.
void Instance::findCalls(std::vector<std::string>& notes) {
    const auto get = [&](auto& function, const char* extension, const char* name) {
        if (!has(extension)) return;
        PFN_xrVoidFunction found = nullptr;
        const XrResult result = xrGetInstanceProcAddr(handle.get(), name, &found);
        if (XR_SUCCEEDED(result) && found) {
            function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
            return;
        }
        std::erase(extensions, extension);
        notes.push_back(fmt::format("{}: {}: the runtime grants {} without this function: it is not used",
                                    name, resultName(result), extension));
    };
    get(calls.insertLabel, XR_EXT_DEBUG_UTILS_EXTENSION_NAME, "xrSessionInsertDebugUtilsLabelEXT");
    get(calls.getVisibilityMask, XR_KHR_VISIBILITY_MASK_EXTENSION_NAME, "xrGetVisibilityMaskKHR");
    get(calls.convertTimespecTimeToTime, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
        "xrConvertTimespecTimeToTimeKHR");
    get(calls.convertTimeToTimespecTime, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME,
        "xrConvertTimeToTimespecTimeKHR");
    if (!calls.convertTimeToTimespecTime)
        calls.convertTimespecTimeToTime = nullptr;  // both directions are needed
    get(calls.getRefreshRate, XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, "xrGetDisplayRefreshRateFB");
    get(calls.getStationaryGenerationId, XR_EXT_STATIONARY_REFERENCE_SPACE_EXTENSION_NAME,
        "xrGetStationaryReferenceSpaceGenerationIdEXT");
    get(calls.createHandTracker, XR_EXT_HAND_TRACKING_EXTENSION_NAME, "xrCreateHandTrackerEXT");
    get(calls.destroyHandTracker, XR_EXT_HAND_TRACKING_EXTENSION_NAME, "xrDestroyHandTrackerEXT");
    get(calls.locateHandJoints, XR_EXT_HAND_TRACKING_EXTENSION_NAME, "xrLocateHandJointsEXT");
}

void Instance::findSystem() {
    auto info = makeStruct<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
    info.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    check(xrGetSystem(handle.get(), &info, &system), "xrGetSystem",
          "runtime \"" + runtime_name + "\" has no headset: connect it and switch it on");
    auto hands = makeStruct<XrSystemHandTrackingPropertiesEXT>(XR_TYPE_SYSTEM_HAND_TRACKING_PROPERTIES_EXT);
    auto properties = makeStruct<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    if (has(XR_EXT_HAND_TRACKING_EXTENSION_NAME)) properties.next = &hands;
    check(xrGetSystemProperties(handle.get(), system, &properties), "xrGetSystemProperties",
          "the headset was disconnected: connect it again");
    system_name = properties.systemName;
    limits = properties.graphicsProperties;
    supports_hand_tracking = hands.supportsHandTracking;
}

void Instance::readGraphicsRequirements() {
    const auto get =
        find<PFN_xrGetVulkanGraphicsRequirements2KHR>(handle.get(), "xrGetVulkanGraphicsRequirements2KHR");
    auto needs = makeStruct<XrGraphicsRequirementsVulkan2KHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
    check(get(handle.get(), system, &needs), "xrGetVulkanGraphicsRequirements2KHR",
          "the runtime cannot use Vulkan for this headset");
    const auto packed = [](XrVersion v) {
        return std::uint32_t(XR_VERSION_MAJOR(v) << 16) | std::uint32_t(XR_VERSION_MINOR(v));
    };
    min_vulkan_ = packed(needs.minApiVersionSupported);
    max_vulkan_ = packed(needs.maxApiVersionSupported);
}

VkResult Instance::createVulkanInstance(PFN_vkGetInstanceProcAddr loader,
                                        const VkInstanceCreateInfo* create_info, VkInstance* out) {
    const std::uint32_t api = create_info->pApplicationInfo ? create_info->pApplicationInfo->apiVersion : 0;
    const std::uint32_t asked =
        api ? (VK_API_VERSION_MAJOR(api) << 16) | VK_API_VERSION_MINOR(api) : 1u << 16;
    if (asked < min_vulkan_ || asked > max_vulkan_)
        throw XrError(fmt::format(
            "xrGetVulkanGraphicsRequirements2KHR: runtime \"{}\" supports Vulkan {} to {}, this program "
            "needs "
            "{}",
            runtime_name, versionText(min_vulkan_), versionText(max_vulkan_), versionText(asked)));

    const auto make = find<PFN_xrCreateVulkanInstanceKHR>(handle.get(), "xrCreateVulkanInstanceKHR");
    auto info = makeStruct<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
    info.systemId = system;
    info.pfnGetInstanceProcAddr = loader;
    info.vulkanCreateInfo = create_info;
    VkResult result = VK_SUCCESS;
    check(make(handle.get(), &info, out, &result), "xrCreateVulkanInstanceKHR",
          "the runtime could not set up Vulkan: is a Vulkan driver installed?");
    return result;
}

VkPhysicalDevice Instance::vulkanPhysicalDevice(VkInstance vulkan) {
    const auto get = find<PFN_xrGetVulkanGraphicsDevice2KHR>(handle.get(), "xrGetVulkanGraphicsDevice2KHR");
    auto info = makeStruct<XrVulkanGraphicsDeviceGetInfoKHR>(XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
    info.systemId = system;
    info.vulkanInstance = vulkan;
    VkPhysicalDevice device = VK_NULL_HANDLE;
    check(get(handle.get(), &info, &device), "xrGetVulkanGraphicsDevice2KHR",
          "the runtime names no GPU that drives the headset");
    return device;
}

VkResult Instance::createVulkanDevice(PFN_vkGetInstanceProcAddr loader, VkPhysicalDevice gpu,
                                      const VkDeviceCreateInfo* create_info, VkDevice* out) {
    const auto make = find<PFN_xrCreateVulkanDeviceKHR>(handle.get(), "xrCreateVulkanDeviceKHR");
    auto info = makeStruct<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
    info.systemId = system;
    info.pfnGetInstanceProcAddr = loader;
    info.vulkanPhysicalDevice = gpu;
    info.vulkanCreateInfo = create_info;
    VkResult result = VK_SUCCESS;
    check(make(handle.get(), &info, out, &result), "xrCreateVulkanDeviceKHR",
          "the runtime could not open the GPU that drives the headset");
    return result;
}

}  // namespace stylet::xr
