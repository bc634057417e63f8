#include "api.h"
#include "objects.h"
#include "verify.h"

namespace xrmock {

namespace {

VulkanInstance& madeHere(Instance& instance, VkInstance vulkan_instance) {
    for (VulkanInstance& each : instance.vulkan_instances) {
        if (each.instance == vulkan_instance) return each;
    }
    refuse(XR_ERROR_VALIDATION_FAILURE, "the VkInstance was not made by xrCreateVulkanInstanceKHR");
}

}  // namespace

XrResult createVulkanInstance(Call& call, XrInstance handle, const XrVulkanInstanceCreateInfoKHR* info,
                              VkInstance* vulkan_instance, VkResult* vulkan_result) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
    requireSystem(info->systemId);
    require(info->createFlags == 0 && info->pfnGetInstanceProcAddr != nullptr &&
                info->vulkanCreateInfo != nullptr && vulkan_instance != nullptr && vulkan_result != nullptr,
            XR_ERROR_VALIDATION_FAILURE, "an argument is null or createFlags is not 0");
    const auto create = reinterpret_cast<PFN_vkCreateInstance>(
        info->pfnGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance"));
    require(create != nullptr, XR_ERROR_VALIDATION_FAILURE,
            "pfnGetInstanceProcAddr does not know vkCreateInstance");
    instance.vulkan_instances.reserve(instance.vulkan_instances.size() + 1);
    // The runtime needs nothing beyond what the application asks for.
    *vulkan_result = create(info->vulkanCreateInfo, info->vulkanAllocator, vulkan_instance);
    if (*vulkan_result == VK_SUCCESS) {
        // A driver may hand out the value of an instance that the application has destroyed.
        std::erase_if(instance.vulkan_instances,
                      [&](const VulkanInstance& each) { return each.instance == *vulkan_instance; });
        instance.vulkan_instances.push_back({*vulkan_instance, info->pfnGetInstanceProcAddr});
    }
    return XR_SUCCESS;
}

XrResult getVulkanGraphicsDevice2(Call& call, XrInstance handle, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                  VkPhysicalDevice* device) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
    requireSystem(info->systemId);
    require(device != nullptr, XR_ERROR_VALIDATION_FAILURE, "vulkanPhysicalDevice is null");
    VulkanInstance& vulkan = madeHere(instance, info->vulkanInstance);
    vulkan.physical_device = choosePhysicalDevice(vulkan);
    require(vulkan.physical_device != VK_NULL_HANDLE, XR_ERROR_RUNTIME_FAILURE, "Vulkan offers no device");
    *device = vulkan.physical_device;
    return XR_SUCCESS;
}

XrResult createVulkanDevice(Call& call, XrInstance handle, const XrVulkanDeviceCreateInfoKHR* info,
                            VkDevice* device, VkResult* vulkan_result) {
    Instance& instance = call.live<Instance>(handle);
    requireStruct(info, XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
    requireSystem(info->systemId);
    require(info->createFlags == 0 && info->pfnGetInstanceProcAddr != nullptr &&
                info->vulkanCreateInfo != nullptr && device != nullptr && vulkan_result != nullptr,
            XR_ERROR_VALIDATION_FAILURE, "an argument is null or createFlags is not 0");
    const auto vulkan = std::find_if(instance.vulkan_instances.begin(), instance.vulkan_instances.end(),
                                     [&](const VulkanInstance& each) {
                                         return each.physical_device != VK_NULL_HANDLE &&
                                                each.physical_device == info->vulkanPhysicalDevice;
                                     });
    require(vulkan != instance.vulkan_instances.end(), XR_ERROR_VALIDATION_FAILURE,
            "not the device that xrGetVulkanGraphicsDevice2KHR named");
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(
        info->pfnGetInstanceProcAddr(vulkan->instance, "vkCreateDevice"));
    require(create != nullptr, XR_ERROR_VALIDATION_FAILURE,
            "pfnGetInstanceProcAddr does not know vkCreateDevice");
    *vulkan_result =
        create(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, device);
    return XR_SUCCESS;
}

XrResult getVulkanGraphicsRequirements2(Call& call, XrInstance handle, XrSystemId system,
                                        XrGraphicsRequirementsVulkanKHR* requirements) {
    Instance& instance = call.live<Instance>(handle);
    requireSystem(system);
    requireStruct(requirements, XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN2_KHR);
    requirements->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
    requirements->maxApiVersionSupported = XR_MAKE_VERSION(1, 1023, 4095);
    instance.graphics_requirements_asked = true;
    return XR_SUCCESS;
}

}  // namespace xrmock
