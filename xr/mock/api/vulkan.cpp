#include <algorithm>
#include <utility>

#include "api/api.h"
#include "world/objects.h"
#include "world/two_call.h"
#include "world/verify.h"

namespace xrmock {

namespace {

VulkanInstance& findCreated(Instance& instance, VkInstance vulkan_instance) {
    for (VulkanInstance& each : instance.vulkan_instances)
        if (each.instance == vulkan_instance && each.created_by_runtime) return each;
    refuse(XR_ERROR_VALIDATION_FAILURE, "the VkInstance was not made by xrCreateVulkanInstanceKHR");
}

VulkanInstance& findOwner(Instance& instance, VkPhysicalDevice device) {
    for (VulkanInstance& each : instance.vulkan_instances)
        if (each.created_by_runtime && device != VK_NULL_HANDLE && each.physical_device == device)
            return each;
    refuse(XR_ERROR_HANDLE_INVALID, "not the device that xrGetVulkanGraphicsDevice2KHR named");
}

// A driver may reuse the handle of a destroyed instance, so a new entry replaces an older one.
void storeInstance(Instance& instance, VulkanInstance vulkan) {
    std::erase_if(instance.vulkan_instances,
                  [&](const VulkanInstance& each) { return each.instance == vulkan.instance; });
    instance.vulkan_instances.push_back(std::move(vulkan));
}

// Drivers also reuse the handles of GPUs, so a GPU belongs to the Vulkan instance for which it was last
// queried.
VkPhysicalDevice chooseDevice(Instance& instance, VulkanInstance& vulkan) {
    const VkPhysicalDevice chosen = choosePhysicalDevice(vulkan);
    require(chosen != VK_NULL_HANDLE, XR_ERROR_RUNTIME_FAILURE, "Vulkan offers no device");
    for (VulkanInstance& each : instance.vulkan_instances)
        if (each.physical_device == chosen) each.physical_device = VK_NULL_HANDLE;
    return vulkan.physical_device = chosen;
}

// Checks the arguments of xrCreateVulkanInstanceKHR and xrCreateVulkanDeviceKHR.
template <class Info, class Created>
void requireCreateArguments(const Info* info, XrStructureType type, const Created* created,
                            const VkResult* result) {
    requireStruct(info, type);
    requireSystem(info->systemId);
    requireValid(info->createFlags == 0 && info->pfnGetInstanceProcAddr != nullptr &&
                     info->vulkanCreateInfo != nullptr && created != nullptr && result != nullptr,
                 "an argument is null or createFlags is not 0");
}

std::uint32_t requestedApiVersion(const VkInstanceCreateInfo& info) {
    const bool given = info.pApplicationInfo != nullptr && info.pApplicationInfo->apiVersion != 0;
    return given ? info.pApplicationInfo->apiVersion : VK_API_VERSION_1_0;
}

}  // namespace

XrResult createVulkanInstance(Call& call, XrInstance handle, const XrVulkanInstanceCreateInfoKHR* info,
                              VkInstance* vulkan_instance, VkResult* vulkan_result) {
    call.live<Instance>(handle);
    requireCreateArguments(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR, vulkan_instance, vulkan_result);
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(
        info->pfnGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance"));
    requireValid(create != nullptr, "pfnGetInstanceProcAddr does not know vkCreateInstance");
    *vulkan_result = call.runUnlocked(
        [&] { return create(info->vulkanCreateInfo, info->vulkanAllocator, vulkan_instance); });
    if (*vulkan_result != VK_SUCCESS) return XR_SUCCESS;
    VulkanInstance vulkan{*vulkan_instance, info->pfnGetInstanceProcAddr};
    vulkan.api_version = requestedApiVersion(*info->vulkanCreateInfo);
    storeInstance(call.live<Instance>(handle), std::move(vulkan));
    return XR_SUCCESS;
}

XrResult getVulkanGraphicsDevice2(Call& call, XrInstance handle, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                  VkPhysicalDevice* device) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
    requireSystem(info->systemId);
    requireValid(device != nullptr, "vulkanPhysicalDevice is null");
    *device = chooseDevice(instance, findCreated(instance, info->vulkanInstance));
    return XR_SUCCESS;
}

XrResult createVulkanDevice(Call& call, XrInstance handle, const XrVulkanDeviceCreateInfoKHR* info,
                            VkDevice* device, VkResult* vulkan_result) {
    call.live<Instance>(handle);
    requireCreateArguments(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR, device, vulkan_result);
    const VkInstance vulkan_instance =
        findOwner(call.live<Instance>(handle), info->vulkanPhysicalDevice).instance;
    const auto create =
        reinterpret_cast<PFN_vkCreateDevice>(info->pfnGetInstanceProcAddr(vulkan_instance, "vkCreateDevice"));
    requireValid(create != nullptr, "pfnGetInstanceProcAddr does not know vkCreateDevice");
    *vulkan_result = call.runUnlocked([&] {
        return create(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, device);
    });
    if (*vulkan_result != VK_SUCCESS) return XR_SUCCESS;
    findOwner(call.live<Instance>(handle), info->vulkanPhysicalDevice).devices.push_back(*device);
    return XR_SUCCESS;
}

XrResult getVulkanGraphicsRequirements(Call& call, XrInstance handle, XrSystemId system,
                                       XrGraphicsRequirementsVulkanKHR* requirements) {
    Instance& instance = call.live<Instance>(handle);
    requireSystem(system);
    requireStruct(requirements, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
    requirements->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
    requirements->maxApiVersionSupported = XR_MAKE_VERSION(1, 1023, 4095);
    instance.graphics_requirements_queried = true;
    return XR_SUCCESS;
}

XrResult getVulkanExtensions(Call& call, XrInstance handle, XrSystemId system, std::uint32_t capacity,
                             std::uint32_t* count, char* buffer) {
    call.live<Instance>(handle);
    requireSystem(system);
    return twoCallString(capacity, count, buffer, "");
}

XrResult getVulkanGraphicsDevice(Call& call, XrInstance handle, XrSystemId system, VkInstance vulkan_instance,
                                 VkPhysicalDevice* device) {
    Instance& instance = call.live<Instance>(handle);
    requireSystem(system);
    requireValid(vulkan_instance != VK_NULL_HANDLE && device != nullptr,
                 "vkInstance or vkPhysicalDevice is null");
    for (VulkanInstance& each : instance.vulkan_instances) {
        if (each.instance != vulkan_instance) continue;
        *device = chooseDevice(instance, each);
        return XR_SUCCESS;
    }
    VulkanInstance vulkan{vulkan_instance, findVulkanLoader()};
    require(vulkan.getInstanceProcAddr != nullptr, XR_ERROR_RUNTIME_FAILURE, "no Vulkan loader is in use");
    vulkan.created_by_runtime = false;
    *device = chooseDevice(instance, vulkan);
    instance.vulkan_instances.push_back(std::move(vulkan));
    return XR_SUCCESS;
}

}  // namespace xrmock
