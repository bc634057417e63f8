#include "painter.h"

namespace stylet::xr {
namespace {

constexpr std::uint32_t kQueueFamily = 0;  // makeDevice() checks that it supports graphics

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

void Painter::clear(const Area& area, const vk::ClearValue& value) {
    const auto key = std::pair(area.image, area.layer);
    if (!views_.contains(key))
        views_.emplace(
            key, vk::raii::ImageView(
                     device_, vk::ImageViewCreateInfo({}, area.image, vk::ImageViewType::e2D, area.format, {},
                                                      {area.aspect, 0, 1, area.layer, 1})));
    const bool is_depth = area.aspect == vk::ImageAspectFlagBits::eDepth;
    vk::RenderingAttachmentInfo target(*views_.at(key), is_depth
                                                            ? vk::ImageLayout::eDepthStencilAttachmentOptimal
                                                            : vk::ImageLayout::eColorAttachmentOptimal);
    target.loadOp = vk::AttachmentLoadOp::eClear;
    target.storeOp = vk::AttachmentStoreOp::eStore;
    target.clearValue = value;
    vk::RenderingInfo rendering({}, {{0, 0}, {area.width, area.height}}, 1);
    if (is_depth)
        rendering.pDepthAttachment = &target;
    else
        rendering.setColorAttachments(target);
    commands_.beginRendering(rendering);
    commands_.endRendering();
}

void Painter::submit() {
    commands_.end();
    queue_.submit(vk::SubmitInfo({}, {}, *commands_));
    queue_.waitIdle();
}

void Painter::paint(VkImage image, const std::array<std::array<float, 4>, 2>& linear_colours) {
    commands_.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    for (std::uint32_t eye = 0; eye < 2; ++eye)
        clear({image, vk::Format(session_.colourFormat()), vk::ImageAspectFlagBits::eColor, eye,
               session_.width(), session_.height()},
              vk::ClearColorValue(linear_colours[eye]));
    submit();
}

void Painter::paintPanel(VkImage image, std::uint32_t width, std::uint32_t height,
                         const std::array<float, 4>& linear_colour) {
    commands_.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    clear({image, vk::Format(session_.panelFormat()), vk::ImageAspectFlagBits::eColor, 0, width, height},
          vk::ClearColorValue(linear_colour));
    submit();
}

void Painter::clearDepth(VkImage image, float depth) {
    commands_.begin({vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    for (std::uint32_t eye = 0; eye < 2; ++eye)
        clear({image, vk::Format::eD32Sfloat, vk::ImageAspectFlagBits::eDepth, eye, session_.width(),
               session_.height()},
              vk::ClearDepthStencilValue(depth));
    submit();
}

}  // namespace stylet::xr
