#include "xr/instance.h"

#include <algorithm>
#include <cstring>

namespace stylet::xr {
namespace {

std::string noRuntime() {
    std::string text = "no OpenXR runtime could be reached; looked at ";
    const auto places = runtimeSearchPath();
    for (std::size_t i = 0; i < places.size(); ++i)
        text += (i ? ", " : "") + places[i];
    return text + "; start the headset's runtime, or set XR_RUNTIME_JSON to its manifest";
}

std::vector<XrExtensionProperties> offeredExtensions() {
    const char* call = "xrEnumerateInstanceExtensionProperties";
    std::uint32_t count = 0;
    check(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr), call, noRuntime());
    std::vector<XrExtensionProperties> offered(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, {}, 0});
    check(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, offered.data()), call, noRuntime());
    return offered;
}

bool offers(const std::vector<XrExtensionProperties>& offered, const char* name) {
    return std::any_of(offered.begin(), offered.end(),
                       [&](const auto& e) { return std::strcmp(e.extensionName, name) == 0; });
}

template <typename Function>
Function find(XrInstance instance, const char* name) {
    PFN_xrVoidFunction function = nullptr;
    check(xrGetInstanceProcAddr(instance, name, &function), name,
          "the runtime does not keep to its own extension list");
    return reinterpret_cast<Function>(function);
}

std::string versionText(std::uint32_t major_minor) {
    return std::to_string(major_minor >> 16) + "." + std::to_string(major_minor & 0xffff);
}

}  // namespace

Instance::Instance(const std::string& application_name) {
    create(application_name);
    findSystem();
    readGraphicsRequirements();
}

void Instance::create(const std::string& application_name) {
    const auto offered = offeredExtensions();
    if (!offers(offered, XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME))
        throw XrError("xrEnumerateInstanceExtensionProperties: the OpenXR runtime does not offer " +
                      std::string(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME) +
                      ": it cannot show pictures made with Vulkan");
    std::vector<const char*> wanted{XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
    const bool debug_utils = offers(offered, XR_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (debug_utils) wanted.push_back(XR_EXT_DEBUG_UTILS_EXTENSION_NAME);

    auto info = typed<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    application_name.copy(info.applicationInfo.applicationName, XR_MAX_APPLICATION_NAME_SIZE - 1);
    std::string("Stylet").copy(info.applicationInfo.engineName, XR_MAX_ENGINE_NAME_SIZE - 1);
    // Debian's loader refuses 1.1.
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
    info.enabledExtensionCount = std::uint32_t(wanted.size());
    info.enabledExtensionNames = wanted.data();
    check(xrCreateInstance(&info, handle.out()), "xrCreateInstance", noRuntime());

    auto properties = typed<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
    check(xrGetInstanceProperties(handle.get(), &properties), "xrGetInstanceProperties",
          "the OpenXR runtime does not say what it is");
    runtime_name = properties.runtimeName;
    if (debug_utils)
        insertLabel =
            find<PFN_xrSessionInsertDebugUtilsLabelEXT>(handle.get(), "xrSessionInsertDebugUtilsLabelEXT");
}

void Instance::findSystem() {
    auto info = typed<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
    info.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
    check(xrGetSystem(handle.get(), &info, &system), "xrGetSystem",
          "runtime \"" + runtime_name + "\" has no headset: connect it and switch it on");
    auto properties = typed<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
    check(xrGetSystemProperties(handle.get(), system, &properties), "xrGetSystemProperties",
          "the headset was lost while it was being asked about");
    system_name = properties.systemName;
}

void Instance::readGraphicsRequirements() {
    const auto get =
        find<PFN_xrGetVulkanGraphicsRequirements2KHR>(handle.get(), "xrGetVulkanGraphicsRequirements2KHR");
    auto needs = typed<XrGraphicsRequirementsVulkan2KHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
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
        throw XrError("xrGetVulkanGraphicsRequirements2KHR: runtime \"" + runtime_name + "\" takes Vulkan " +
                      versionText(min_vulkan_) + " to " + versionText(max_vulkan_) + ", this program needs " +
                      versionText(asked));

    const auto make = find<PFN_xrCreateVulkanInstanceKHR>(handle.get(), "xrCreateVulkanInstanceKHR");
    auto info = typed<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
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
    auto info = typed<XrVulkanGraphicsDeviceGetInfoKHR>(XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
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
    auto info = typed<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
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
