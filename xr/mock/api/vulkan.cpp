#include <algorithm>
#include <utility>

#include "api/api.h"
#include "world/objects.h"
#include "world/two_call.h"
#include "world/verify.h"

namespace xrmock {

namespace {

VulkanInstance& madeHere(Instance& instance, VkInstance vulkan_instance) {
    for (VulkanInstance& each : instance.vulkan_instances) {
        if (each.instance == vulkan_instance && each.made_here) return each;
    }
    refuse(XR_ERROR_VALIDATION_FAILURE, "the VkInstance was not made by xrCreateVulkanInstanceKHR");
}

VulkanInstance& ownerOf(Instance& instance, VkPhysicalDevice device) {
    for (VulkanInstance& each : instance.vulkan_instances) {
        if (each.made_here && device != VK_NULL_HANDLE && each.physical_device == device) return each;
    }
    refuse(XR_ERROR_HANDLE_INVALID, "not the device that xrGetVulkanGraphicsDevice2KHR named");
}

// A driver may reuse the handle of a destroyed instance: the newest entry replaces the older one.
void remember(Instance& instance, VulkanInstance vulkan) {
    std::erase_if(instance.vulkan_instances,
                  [&](const VulkanInstance& each) { return each.instance == vulkan.instance; });
    instance.vulkan_instances.push_back(std::move(vulkan));
}

// Drivers also reuse the handles of GPUs, so a GPU belongs to the Vulkan instance that was queried last.
VkPhysicalDevice chosenDevice(Instance& instance, VulkanInstance& vulkan) {
    const VkPhysicalDevice chosen = choosePhysicalDevice(vulkan);
    require(chosen != VK_NULL_HANDLE, XR_ERROR_RUNTIME_FAILURE, "Vulkan offers no device");
    for (VulkanInstance& each : instance.vulkan_instances) {
        if (each.physical_device == chosen) each.physical_device = VK_NULL_HANDLE;
    }
    return vulkan.physical_device = chosen;
}

std::uint32_t apiVersionOf(const VkInstanceCreateInfo& info) {
    const bool given = info.pApplicationInfo != nullptr && info.pApplicationInfo->apiVersion != 0;
    return given ? info.pApplicationInfo->apiVersion : VK_API_VERSION_1_0;
}

// The runtime requires no additional extensions.
XrResult noExtensions(Call& call, XrInstance handle, XrSystemId system, std::uint32_t capacity,
                      std::uint32_t* count, char* buffer) {
    call.live<Instance>(handle);
    requireSystem(system);
    return twoCallString(capacity, count, buffer, "");
}

}  // namespace

XrResult createVulkanInstance(Call& call, XrInstance handle, const XrVulkanInstanceCreateInfoKHR* info,
                              VkInstance* vulkan_instance, VkResult* vulkan_result) {
    call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
    requireSystem(info->systemId);
    require(info->createFlags == 0 && info->pfnGetInstanceProcAddr != nullptr &&
                info->vulkanCreateInfo != nullptr && vulkan_instance != nullptr && vulkan_result != nullptr,
            XR_ERROR_VALIDATION_FAILURE, "an argument is null or createFlags is not 0");
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(
        info->pfnGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance"));
    require(create != nullptr, XR_ERROR_VALIDATION_FAILURE,
            "pfnGetInstanceProcAddr does not know vkCreateInstance");
    *vulkan_result =
        call.unlocked([&] { return create(info->vulkanCreateInfo, info->vulkanAllocator, vulkan_instance); });
    if (*vulkan_result != VK_SUCCESS) return XR_SUCCESS;
    VulkanInstance vulkan{*vulkan_instance, info->pfnGetInstanceProcAddr};
    vulkan.api_version = apiVersionOf(*info->vulkanCreateInfo);
    remember(call.live<Instance>(handle), std::move(vulkan));
    return XR_SUCCESS;
}

XrResult getVulkanGraphicsDevice2(Call& call, XrInstance handle, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                  VkPhysicalDevice* device) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
    requireSystem(info->systemId);
    require(device != nullptr, XR_ERROR_VALIDATION_FAILURE, "vulkanPhysicalDevice is null");
    *device = chosenDevice(instance, madeHere(instance, info->vulkanInstance));
    return XR_SUCCESS;
}

XrResult createVulkanDevice(Call& call, XrInstance handle, const XrVulkanDeviceCreateInfoKHR* info,
                            VkDevice* device, VkResult* vulkan_result) {
    call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
    requireSystem(info->systemId);
    require(info->createFlags == 0 && info->pfnGetInstanceProcAddr != nullptr &&
                info->vulkanCreateInfo != nullptr && device != nullptr && vulkan_result != nullptr,
            XR_ERROR_VALIDATION_FAILURE, "an argument is null or createFlags is not 0");
    const VkInstance vulkan_instance =
        ownerOf(call.live<Instance>(handle), info->vulkanPhysicalDevice).instance;
    const auto create =
        reinterpret_cast<PFN_vkCreateDevice>(info->pfnGetInstanceProcAddr(vulkan_instance, "vkCreateDevice"));
    require(create != nullptr, XR_ERROR_VALIDATION_FAILURE,
            "pfnGetInstanceProcAddr does not know vkCreateDevice");
    *vulkan_result = call.unlocked([&] {
        return create(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, device);
    });
    if (*vulkan_result != VK_SUCCESS) return XR_SUCCESS;
    ownerOf(call.live<Instance>(handle), info->vulkanPhysicalDevice).devices.push_back(*device);
    return XR_SUCCESS;
}

XrResult getVulkanGraphicsRequirements(Call& call, XrInstance handle, XrSystemId system,
                                       XrGraphicsRequirementsVulkanKHR* requirements) {
    Instance& instance = call.live<Instance>(handle);
    requireSystem(system);
    requireStruct(requirements, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
    requirements->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
    requirements->maxApiVersionSupported = XR_MAKE_VERSION(1, 1023, 4095);
    instance.graphics_requirements_asked = true;
    return XR_SUCCESS;
}

XrResult getVulkanInstanceExtensions(Call& call, XrInstance handle, XrSystemId system, std::uint32_t capacity,
                                     std::uint32_t* count, char* buffer) {
    return noExtensions(call, handle, system, capacity, count, buffer);
}

XrResult getVulkanDeviceExtensions(Call& call, XrInstance handle, XrSystemId system, std::uint32_t capacity,
                                   std::uint32_t* count, char* buffer) {
    return noExtensions(call, handle, system, capacity, count, buffer);
}

XrResult getVulkanGraphicsDevice(Call& call, XrInstance handle, XrSystemId system, VkInstance vulkan_instance,
                                 VkPhysicalDevice* device) {
    Instance& instance = call.live<Instance>(handle);
    requireSystem(system);
    require(vulkan_instance != VK_NULL_HANDLE && device != nullptr, XR_ERROR_VALIDATION_FAILURE,
            "vkInstance or vkPhysicalDevice is null");
    for (VulkanInstance& each : instance.vulkan_instances) {
        if (each.instance != vulkan_instance) continue;
        *device = chosenDevice(instance, each);
        return XR_SUCCESS;
    }
    VulkanInstance vulkan{vulkan_instance, loaderInUse()};
    require(vulkan.getInstanceProcAddr != nullptr, XR_ERROR_RUNTIME_FAILURE, "no Vulkan loader is in use");
    vulkan.made_here = false;
    *device = chosenDevice(instance, vulkan);
    instance.vulkan_instances.push_back(std::move(vulkan));
    return XR_SUCCESS;
}

}  // namespace xrmock
