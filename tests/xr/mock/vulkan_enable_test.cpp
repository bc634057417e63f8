// XR_KHR_vulkan_enable, and the rules for using both Vulkan extensions with each other's objects.
#include <cstdint>
#include <string_view>

#include "tests/xr/mock/client/client.h"

namespace mock_test {
namespace {

class VulkanEnable : public MockTest {
  protected:
    // The extension names that one of the two string functions returns.
    template <class Function>
    std::string extensionNames(const char* function_name) {
        const auto function = load<Function>(instance_, function_name);
        std::uint32_t count = 0;
        EXPECT_EQ(function(instance_, system_, 0, &count, nullptr), XR_SUCCESS);
        std::string names(count, '?');
        EXPECT_EQ(function(instance_, system_, count, &count, names.data()), XR_SUCCESS);
        EXPECT_EQ(names.back(), '\0');
        EXPECT_EQ(function(instance_, system_ + 1, 0, &count, nullptr), XR_ERROR_SYSTEM_INVALID);
        names.pop_back();
        return names;
    }
    void requestRequirements() {
        auto requirements =
            makeStruct<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR);
        const auto function =
            load<PFN_xrGetVulkanGraphicsRequirementsKHR>(instance_, "xrGetVulkanGraphicsRequirementsKHR");
        ASSERT_EQ(function(instance_, system_, &requirements), XR_SUCCESS);
        EXPECT_LE(requirements.minApiVersionSupported, XR_MAKE_VERSION(1, 0, 0));
        EXPECT_GE(requirements.maxApiVersionSupported, XR_MAKE_VERSION(1, 3, 0));
        requirements.type = XR_TYPE_FRAME_STATE;
        EXPECT_EQ(function(instance_, system_, &requirements), XR_ERROR_VALIDATION_FAILURE);
    }
    void createVulkanInstance() {
        VkInstanceCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
        ASSERT_EQ(vkCreateInstance(&info, nullptr, &vk_instance_), VK_SUCCESS);
    }
    XrResult requestDevice(VkInstance instance) {
        return load<PFN_xrGetVulkanGraphicsDeviceKHR>(instance_, "xrGetVulkanGraphicsDeviceKHR")(
            instance_, system_, instance, &vk_physical_device_);
    }
    void createVulkanDevice() {
        const float priority = 1;
        VkDeviceQueueCreateInfo queue{};
        queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
        queue.queueCount = 1;
        queue.pQueuePriorities = &priority;
        VkDeviceCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
        info.queueCreateInfoCount = 1;
        info.pQueueCreateInfos = &queue;
        ASSERT_EQ(vkCreateDevice(vk_physical_device_, &info, nullptr, &vk_device_), VK_SUCCESS);
    }
};

TEST_F(VulkanEnable, AnApplicationBringsItsOwnVulkan) {
    extensions_ = {XR_KHR_VULKAN_ENABLE_EXTENSION_NAME};
    start();
    requestRequirements();
    EXPECT_EQ(extensionNames<PFN_xrGetVulkanInstanceExtensionsKHR>("xrGetVulkanInstanceExtensionsKHR"), "");
    EXPECT_EQ(extensionNames<PFN_xrGetVulkanDeviceExtensionsKHR>("xrGetVulkanDeviceExtensionsKHR"), "");
    createVulkanInstance();
    EXPECT_EQ(requestDevice(VK_NULL_HANDLE), XR_ERROR_VALIDATION_FAILURE);
    ASSERT_EQ(requestDevice(vk_instance_), XR_SUCCESS);
    const VkPhysicalDevice chosen = vk_physical_device_;
    ASSERT_EQ(requestDevice(vk_instance_), XR_SUCCESS);
    EXPECT_EQ(vk_physical_device_, chosen);
    createVulkanDevice();
    const XrGraphicsBindingVulkanKHR graphics = binding();
    for (int i = 0; i < 3; ++i) {
        ASSERT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
        cycle(createSwapchain(swapchainInfo()).handle);
        // In Vulkan 1.0 an sRGB image cannot have a usage that only its linear views support.
        XrSwapchainCreateInfo info = swapchainInfo();
        info.usageFlags |= XR_SWAPCHAIN_USAGE_UNORDERED_ACCESS_BIT;
        VkFormatProperties format;
        vkGetPhysicalDeviceFormatProperties(vk_physical_device_, VK_FORMAT_R8G8B8A8_SRGB, &format);
        const bool has_storage = (format.optimalTilingFeatures & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT) != 0;
        XrSwapchain swapchain = XR_NULL_HANDLE;
        EXPECT_EQ(xrCreateSwapchain(session_, &info, &swapchain),
                  has_storage ? XR_SUCCESS : XR_ERROR_FEATURE_UNSUPPORTED);
        ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
    }
}

TEST_F(VulkanEnable, TheGraphicsDeviceMustBeQueriedFirst) {
    extensions_ = {XR_KHR_VULKAN_ENABLE_EXTENSION_NAME};
    start();
    createVulkanInstance();
    ASSERT_EQ(requestDevice(vk_instance_), XR_SUCCESS);
    createVulkanDevice();
    XrGraphicsBindingVulkanKHR graphics = binding();
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_REQUIREMENTS_CALL_MISSING);
    requestRequirements();
    graphics.instance = reinterpret_cast<VkInstance>(0x1234);
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    graphics = binding();
    graphics.device = VK_NULL_HANDLE;
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    graphics = binding();
    graphics.queueFamilyIndex = 77;
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    graphics = binding();
    graphics.queueIndex = 77;
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    graphics = binding();
    const XrGraphicsBindingVulkanKHR second = binding();
    graphics.next = &second;
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    graphics.next = nullptr;
    ASSERT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
}

TEST_F(VulkanEnable, TheSecondExtensionRequiresItsOwnObjects) {
    extensions_ = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
    startVulkan();
    const VkDevice made_here = vk_device_;
    createVulkanDevice();
    XrGraphicsBindingVulkanKHR graphics = binding();
    EXPECT_EQ(trySession(&graphics, &session_), XR_ERROR_GRAPHICS_DEVICE_INVALID);
    vkDestroyDevice(vk_device_, nullptr);
    vk_device_ = made_here;
    graphics = binding();
    EXPECT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
}

TEST_F(VulkanEnable, AnUnknownDeviceIsRefused) {
    startVulkan();
    VkDeviceCreateInfo vulkan_info{};
    vulkan_info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    auto info = makeStruct<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
    info.systemId = system_;
    info.pfnGetInstanceProcAddr = vkGetInstanceProcAddr;
    info.vulkanCreateInfo = &vulkan_info;
    const auto create = load<PFN_xrCreateVulkanDeviceKHR>(instance_, "xrCreateVulkanDeviceKHR");
    VkDevice device = VK_NULL_HANDLE;
    VkResult result = VK_SUCCESS;
    for (const auto other : {VkPhysicalDevice{VK_NULL_HANDLE}, reinterpret_cast<VkPhysicalDevice>(0x5678)}) {
        info.vulkanPhysicalDevice = other;
        EXPECT_EQ(create(instance_, &info, &device, &result), XR_ERROR_HANDLE_INVALID);
    }
}

// A fake Vulkan whose instances all have the same GPU handle, as if each reused the memory of a destroyed
// one.
namespace reused {

const auto kGpu = reinterpret_cast<VkPhysicalDevice>(0x77);
std::uintptr_t instances = 0;           // number created so far; also the newest handle
VkInstance device_requested = nullptr;  // instance whose vkCreateDevice was looked up last

VkResult createInstance(const VkInstanceCreateInfo*, const VkAllocationCallbacks*, VkInstance* out) {
    *out = reinterpret_cast<VkInstance>(++instances);
    return VK_SUCCESS;
}
VkResult enumerateDevices(VkInstance, std::uint32_t* count, VkPhysicalDevice* devices) {
    *count = 1;
    if (devices != nullptr) *devices = kGpu;
    return VK_SUCCESS;
}
void properties(VkPhysicalDevice, VkPhysicalDeviceProperties* out) {
    *out = {};
}
VkResult createDevice(VkPhysicalDevice, const VkDeviceCreateInfo*, const VkAllocationCallbacks*, VkDevice*) {
    return VK_ERROR_INITIALIZATION_FAILED;
}
PFN_vkVoidFunction lookUp(VkInstance instance, const char* name) {
    const std::string_view function = name;
    if (function == "vkCreateInstance") return reinterpret_cast<PFN_vkVoidFunction>(createInstance);
    if (function == "vkEnumeratePhysicalDevices")
        return reinterpret_cast<PFN_vkVoidFunction>(enumerateDevices);
    if (function == "vkGetPhysicalDeviceProperties") return reinterpret_cast<PFN_vkVoidFunction>(properties);
    device_requested = instance;
    return reinterpret_cast<PFN_vkVoidFunction>(createDevice);
}

}  // namespace reused

TEST_F(VulkanEnable, ADestroyedInstanceIsNotUsedForTheDevice) {
    start();
    const VkInstanceCreateInfo vulkan_info{};
    auto info = makeStruct<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
    info.systemId = system_;
    info.pfnGetInstanceProcAddr = reused::lookUp;
    info.vulkanCreateInfo = &vulkan_info;
    auto get_info = makeStruct<XrVulkanGraphicsDeviceGetInfoKHR>(XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
    get_info.systemId = system_;
    const VkDeviceCreateInfo device_info{};
    auto make = makeStruct<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
    make.systemId = system_;
    make.pfnGetInstanceProcAddr = reused::lookUp;
    make.vulkanCreateInfo = &device_info;
    for (int i = 0; i < 2; ++i) {
        VkResult result = VK_SUCCESS;
        ASSERT_EQ(load<PFN_xrCreateVulkanInstanceKHR>(instance_, "xrCreateVulkanInstanceKHR")(
                      instance_, &info, &get_info.vulkanInstance, &result),
                  XR_SUCCESS);
        ASSERT_EQ(load<PFN_xrGetVulkanGraphicsDevice2KHR>(instance_, "xrGetVulkanGraphicsDevice2KHR")(
                      instance_, &get_info, &make.vulkanPhysicalDevice),
                  XR_SUCCESS);
        VkDevice device = VK_NULL_HANDLE;
        ASSERT_EQ(load<PFN_xrCreateVulkanDeviceKHR>(instance_, "xrCreateVulkanDeviceKHR")(instance_, &make,
                                                                                          &device, &result),
                  XR_SUCCESS);
        EXPECT_EQ(result, VK_ERROR_INITIALIZATION_FAILED);
        EXPECT_EQ(reused::device_requested, get_info.vulkanInstance);
    }
}

// Enables both Vulkan extensions and uses the functions of each with the other's objects.
TEST_F(VulkanEnable, BothExtensionsWorkTogether) {
    startVulkan();  // Vulkan instance and device from XR_KHR_vulkan_enable2
    const VkPhysicalDevice chosen = vk_physical_device_;
    ASSERT_EQ(requestDevice(vk_instance_), XR_SUCCESS);
    EXPECT_EQ(vk_physical_device_, chosen);
    const XrGraphicsBindingVulkanKHR graphics = binding();
    EXPECT_EQ(trySession(&graphics, &session_), XR_SUCCESS);
}

}  // namespace
}  // namespace mock_test
