#include "painter.h"

namespace stylet::xr {
namespace {

constexpr std::uint32_t kQueueFamily = 0;  // checked: it must draw

void require(VkResult result, const char* call) {
    if (result != VK_SUCCESS)
        throw std::runtime_error(std::string(call) + ": " + vk::to_string(vk::Result(result)));
}

VkInstance makeInstance(Session& session, const vk::raii::Context& context) {
    const vk::ApplicationInfo application("xr test", 1, "", 1, VK_API_VERSION_1_3);
    const VkInstanceCreateInfo info = vk::InstanceCreateInfo({}, &application);
    VkInstance instance = VK_NULL_HANDLE;
    require(session.createVulkanInstance(context.getDispatcher()->vkGetInstanceProcAddr, &info, &instance),
            "vkCreateInstance");
    return instance;
}

VkDevice makeDevice(Session& session, const vk::raii::Context& context, const vk::raii::PhysicalDevice& gpu) {
    if (!(gpu.getQueueFamilyProperties().at(kQueueFamily).queueFlags & vk::QueueFlagBits::eGraphics))
        throw std::runtime_error("the first queue family does not draw");
    const float priority = 1.0f;
    const vk::DeviceQueueCreateInfo queue({}, kQueueFamily, 1, &priority);
    vk::PhysicalDeviceVulkan13Features features;
    features.dynamicRendering = true;
    vk::DeviceCreateInfo made({}, queue);
    made.pNext = &features;
    const VkDeviceCreateInfo info = made;
    VkDevice device = VK_NULL_HANDLE;
    require(session.createVulkanDevice(context.getDispatcher()->vkGetInstanceProcAddr, *gpu, &info, &device),
            "vkCreateDevice");
    return device;
}

}  // namespace

Painter::Painter(Session& session)
    : session_(session),
      instance_(context_, makeInstance(session, context_)),
      gpu_(instance_, session.vulkanPhysicalDevice(*instance_)),
      device_(gpu_, makeDevice(session, context_, gpu_)),
      queue_(device_, kQueueFamily, 0),
      pool_(device_, {vk::CommandPoolCreateFlagBits::eResetCommandBuffer, kQueueFamily}),
      commands_(std::move(
          vk::raii::CommandBuffers(device_, {*pool_, vk::CommandBufferLevel::ePrimary, 1}).front())) {}

void Painter::start() {
    session_.start(*instance_, *gpu_, *device_, kQueueFamily);
}

void Painter::paint(VkImage image, const std::array<std::array<float, 4>, 2>& linear_colours) {
    std::vector<vk::raii::ImageView>& eyes = eyes_[image];
    for (std::uint32_t layer = std::uint32_t(eyes.size()); layer < 2; ++layer)
        eyes.emplace_back(device_, vk::ImageViewCreateInfo(
                                       {}, image, vk::ImageViewType::e2D, vk::Format(session_.colourFormat()),
                                       {}, {vk::ImageAspectFlagBits::eColor, 0, 1, layer, 1}));
    commands_.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    for (std::size_t layer = 0; layer < 2; ++layer) {
        vk::RenderingAttachmentInfo colour(*eyes[layer], vk::ImageLayout::eColorAttachmentOptimal);
        colour.loadOp = vk::AttachmentLoadOp::eClear;
        colour.storeOp = vk::AttachmentStoreOp::eStore;
        colour.clearValue = vk::ClearColorValue(linear_colours[layer]);
        const vk::Rect2D whole({0, 0}, {session_.width(), session_.height()});
        commands_.beginRendering(vk::RenderingInfo({}, whole, 1, 0, colour));
        commands_.endRendering();
    }
    commands_.end();
    queue_.submit(vk::SubmitInfo({}, {}, *commands_));
    queue_.waitIdle();
}

}  // namespace stylet::xr
