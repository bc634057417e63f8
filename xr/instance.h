// The OpenXR instance and the headset it found: the loader, extensions, and the calls of
// XR_KHR_vulkan_enable2.
#pragma once

#include <string>

#include "xr/check.h"

namespace stylet::xr {

struct Instance {
    explicit Instance(const std::string& application_name);

    // Each creates through the runtime, which adds what it needs; the runtime also names the GPU.
    VkResult createVulkanInstance(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*);
    VkPhysicalDevice vulkanPhysicalDevice(VkInstance);
    VkResult createVulkanDevice(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo*,
                                VkDevice*);

    Owned<XrInstance, xrDestroyInstance> handle;
    XrSystemId system = XR_NULL_SYSTEM_ID;
    std::string runtime_name;
    std::string system_name;
    PFN_xrSessionInsertDebugUtilsLabelEXT insertLabel = nullptr;  // null without XR_EXT_debug_utils

  private:
    void create(const std::string& application_name);
    void findSystem();
    // Must come before the session is made, or the runtime refuses it.
    void readGraphicsRequirements();

    std::uint32_t min_vulkan_ = 0, max_vulkan_ = 0;  // major << 16 | minor
};

}  // namespace stylet::xr
