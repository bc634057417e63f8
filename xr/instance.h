// The OpenXR instance and its headset: loader, extensions, and the functions of XR_KHR_vulkan_enable2.
#pragma once

#include <string>
#include <vector>

#include "xr/check.h"

namespace stylet::xr {

// Extension functions; null if the extension was not granted.
struct ExtensionCalls {
    PFN_xrSessionInsertDebugUtilsLabelEXT insertLabel = nullptr;
    PFN_xrGetVisibilityMaskKHR getVisibilityMask = nullptr;
    PFN_xrConvertTimespecTimeToTimeKHR convertTimespecTimeToTime = nullptr;
    PFN_xrConvertTimeToTimespecTimeKHR convertTimeToTimespecTime = nullptr;
    PFN_xrGetDisplayRefreshRateFB getRefreshRate = nullptr;
    PFN_xrGetStationaryReferenceSpaceGenerationIdEXT getStationaryGenerationId = nullptr;
    PFN_xrCreateHandTrackerEXT createHandTracker = nullptr;
    PFN_xrDestroyHandTrackerEXT destroyHandTracker = nullptr;
    PFN_xrLocateHandJointsEXT locateHandJoints = nullptr;
};

struct Instance {
    // Throws XrError. Adds a sentence to `notes` for each extension that the runtime offers but does not
    // grant.
    Instance(const std::string& application_name, std::vector<std::string>& notes);

    bool has(std::string_view extension) const;

    // The runtime creates the Vulkan instance and device, adding the extensions it needs. It also selects
    // the GPU.
    VkResult createVulkanInstance(PFN_vkGetInstanceProcAddr, const VkInstanceCreateInfo*, VkInstance*);
    VkPhysicalDevice vulkanPhysicalDevice(VkInstance);
    VkResult createVulkanDevice(PFN_vkGetInstanceProcAddr, VkPhysicalDevice, const VkDeviceCreateInfo*,
                                VkDevice*);

    Owned<XrInstance, xrDestroyInstance> handle;
    XrSystemId system = XR_NULL_SYSTEM_ID;
    std::string runtime_name, runtime_version, system_name;
    std::vector<std::string> extensions;  // granted
    ExtensionCalls calls;
    XrSystemGraphicsProperties limits{};
    bool supports_hand_tracking = false;

  private:
    void create(const std::string& application_name, std::vector<std::string>& notes);
    void findCalls(std::vector<std::string>& notes);
    void findSystem();
    // Required before session creation: otherwise the runtime refuses the session.
    void readGraphicsRequirements();

    std::uint32_t min_vulkan_ = 0, max_vulkan_ = 0;  // major << 16 | minor
};

}  // namespace stylet::xr
