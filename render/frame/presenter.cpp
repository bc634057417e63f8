#include "render/frame/presenter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/gpu/guarded.h"
#include "render/gpu/image_states.h"

namespace stylet::render {
namespace {

const ImageState kPresented{vk::ImageLayout::ePresentSrcKHR, vk::PipelineStageFlagBits2::eNone, {}};

// Prefers an sRGB format, so that pictures are scaled in linear light. With a UNORM format the bytes are
// used as they are.
vk::SurfaceFormatKHR chooseFormat(const std::vector<vk::SurfaceFormatKHR>& offered) {
    for (const vk::Format wanted : {vk::Format::eB8G8R8A8Srgb, vk::Format::eR8G8B8A8Srgb,
                                    vk::Format::eB8G8R8A8Unorm, vk::Format::eR8G8B8A8Unorm})
        for (const vk::SurfaceFormatKHR& format : offered)
            if (format.format == wanted && format.colorSpace == vk::ColorSpaceKHR::eSrgbNonlinear)
                return format;
    throw GpuError("vkGetPhysicalDeviceSurfaceFormatsKHR: this display does not accept 8-bit sRGB pictures");
}

bool isSrgb(vk::Format format) {
    return format == vk::Format::eB8G8R8A8Srgb || format == vk::Format::eR8G8B8A8Srgb;
}

float encoded(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

std::array<vk::Offset3D, 2> corners(std::int32_t x, std::int32_t y, std::uint32_t width,
                                    std::uint32_t height) {
    return {vk::Offset3D{x, y, 0}, vk::Offset3D{x + std::int32_t(width), y + std::int32_t(height), 1}};
}

}  // namespace

struct Presenter::Impl {
    struct Picture {
        GpuImage image;
        Buffer pixels;
        bool changed = false;
    };

    Impl(const Gpu&, VkSurfaceKHR);
    bool createSwapchain(vk::Extent2D wanted);
    void destroySwapchain();
    void upload(Picture&) const;
    void record(vk::Image, std::span<const PlacedPicture>, const std::array<float, 3>& background);
    void submit(std::uint32_t index);
    bool present(std::uint32_t index);
    bool show(vk::Extent2D, std::span<const PlacedPicture>, const std::array<float, 3>& background,
              std::uint64_t timeout_ns);

    const Gpu& gpu;
    vk::raii::SurfaceKHR surface;
    vk::SurfaceFormatKHR format;
    vk::raii::CommandPool pool;
    vk::raii::CommandBuffer commands;
    vk::raii::Fence drawn;
    vk::raii::Semaphore acquired;
    vk::raii::SwapchainKHR swapchain = nullptr;
    vk::Extent2D extent, requested_extent;
    std::vector<vk::Image> images;
    std::vector<vk::raii::Semaphore> shown;  // one per image
    std::vector<Picture> pictures;
};

Presenter::Impl::Impl(const Gpu& g, VkSurfaceKHR taken)
    : gpu(g),
      surface(gpu.instance(), taken),
      pool(gpu.device(), vk::CommandPoolCreateInfo{.flags = vk::CommandPoolCreateFlagBits::eTransient,
                                                   .queueFamilyIndex = gpu.queueFamily()}),
      commands(makeCommandBuffer(gpu, pool)),
      drawn(gpu.device(), vk::FenceCreateInfo{}),
      acquired(gpu.device(), vk::SemaphoreCreateInfo{}) {
    if (!gpu.physicalDevice().getSurfaceSupportKHR(gpu.queueFamily(), *surface))
        throw GpuError("vkGetPhysicalDeviceSurfaceSupportKHR: " + gpu.name() +
                       " cannot show pictures on this display");
    const auto usage = gpu.physicalDevice().getSurfaceCapabilitiesKHR(*surface).supportedUsageFlags;
    if (!(usage & vk::ImageUsageFlagBits::eTransferDst))
        throw GpuError(
            "vkGetPhysicalDeviceSurfaceCapabilitiesKHR: pictures cannot be copied to this display");
    format = chooseFormat(gpu.physicalDevice().getSurfaceFormatsKHR(*surface));
}

void Presenter::Impl::destroySwapchain() {
    gpu.device().waitIdle();
    shown.clear();
    images.clear();
    swapchain = nullptr;
}

// Returns false if the window has no visible area.
bool Presenter::Impl::createSwapchain(vk::Extent2D wanted) {
    const auto can = gpu.physicalDevice().getSurfaceCapabilitiesKHR(*surface);
    const bool ours = can.currentExtent.width == UINT32_MAX;  // the surface takes the size of the swapchain
    const vk::Extent2D size =
        ours ? vk::Extent2D{std::clamp(wanted.width, can.minImageExtent.width, can.maxImageExtent.width),
                            std::clamp(wanted.height, can.minImageExtent.height, can.maxImageExtent.height)}
             : can.currentExtent;
    if (size.width == 0 || size.height == 0) return false;
    gpu.device().waitIdle();
    std::uint32_t count = can.minImageCount + 1;
    if (can.maxImageCount > 0) count = std::min(count, can.maxImageCount);
    const bool opaque = bool(can.supportedCompositeAlpha & vk::CompositeAlphaFlagBitsKHR::eOpaque);
    const vk::raii::SwapchainKHR old = std::move(swapchain);
    swapchain =
        gpu.device().createSwapchainKHR({.surface = *surface,
                                         .minImageCount = count,
                                         .imageFormat = format.format,
                                         .imageColorSpace = format.colorSpace,
                                         .imageExtent = size,
                                         .imageArrayLayers = 1,
                                         .imageUsage = vk::ImageUsageFlagBits::eTransferDst,
                                         .preTransform = can.currentTransform,
                                         .compositeAlpha = opaque ? vk::CompositeAlphaFlagBitsKHR::eOpaque
                                                                  : vk::CompositeAlphaFlagBitsKHR::eInherit,
                                         .presentMode = vk::PresentModeKHR::eFifo,
                                         .clipped = true,
                                         .oldSwapchain = *old});
    extent = size, requested_extent = wanted;
    images.clear(), shown.clear();
    for (const VkImage image : swapchain.getImages()) {
        images.emplace_back(image);
        shown.emplace_back(gpu.device(), vk::SemaphoreCreateInfo{});
    }
    return true;
}

void Presenter::Impl::upload(Picture& picture) const {
    recordUpload(commands, picture.pixels, *picture.image.handle, imagePart(picture.image.extent),
                 kTransferFresh, kTransferRead);
    picture.changed = false;
}

void Presenter::Impl::record(vk::Image target, std::span<const PlacedPicture> placed,
                             const std::array<float, 3>& background) {
    pool.reset();
    commands.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    for (const PlacedPicture& one : placed)
        if (pictures[one.picture].changed) upload(pictures[one.picture]);
    transition(commands, target, kColour, kTransferFresh, kTransferWritten);
    std::array<float, 4> clear{background[0], background[1], background[2], 1.0f};
    if (!isSrgb(format.format))
        for (float& channel : clear)
            channel = encoded(channel);
    commands.clearColorImage(target, kTransferWritten.layout, vk::ClearColorValue(clear),
                             vk::ImageSubresourceRange{kColour, 0, 1, 0, 1});
    for (const PlacedPicture& one : placed) {
        const GpuImage& from = pictures[one.picture].image;
        transition(commands, target, kColour, kTransferWritten, kTransferWritten);
        const vk::ImageBlit scaled{.srcSubresource = {kColour, 0, 0, 1},
                                   .srcOffsets = corners(0, 0, from.extent.width, from.extent.height),
                                   .dstSubresource = {kColour, 0, 0, 1},
                                   .dstOffsets = corners(one.x, one.y, one.width, one.height)};
        commands.blitImage(*from.handle, kTransferRead.layout, target, kTransferWritten.layout, scaled,
                           vk::Filter::eLinear);
    }
    transition(commands, target, kColour, kTransferWritten, kPresented);
    commands.end();
}

void Presenter::Impl::submit(std::uint32_t index) {
    const vk::SemaphoreSubmitInfo wait{.semaphore = *acquired,
                                       .stageMask = vk::PipelineStageFlagBits2::eTransfer};
    const vk::SemaphoreSubmitInfo signal{.semaphore = *shown[index],
                                         .stageMask = vk::PipelineStageFlagBits2::eAllCommands};
    const vk::CommandBufferSubmitInfo info{.commandBuffer = *commands};
    gpu.queue().submit2(vk::SubmitInfo2{.waitSemaphoreInfoCount = 1,
                                        .pWaitSemaphoreInfos = &wait,
                                        .commandBufferInfoCount = 1,
                                        .pCommandBufferInfos = &info,
                                        .signalSemaphoreInfoCount = 1,
                                        .pSignalSemaphoreInfos = &signal},
                        *drawn);
    if (gpu.device().waitForFences(*drawn, true, UINT64_MAX) != vk::Result::eSuccess)
        throw GpuError("vkWaitForFences: the window's picture did not finish");
    gpu.device().resetFences(*drawn);
}

bool Presenter::Impl::present(std::uint32_t index) {
    const vk::PresentInfoKHR info{.waitSemaphoreCount = 1,
                                  .pWaitSemaphores = &*shown[index],
                                  .swapchainCount = 1,
                                  .pSwapchains = &*swapchain,
                                  .pImageIndices = &index};
    if (gpu.queue().presentKHR(info) == vk::Result::eSuboptimalKHR) destroySwapchain();
    return true;
}

bool Presenter::Impl::show(vk::Extent2D window, std::span<const PlacedPicture> placed,
                           const std::array<float, 3>& background, std::uint64_t timeout_ns) {
    if (window.width == 0 || window.height == 0) return false;
    if ((!*swapchain || window != requested_extent) && !createSwapchain(window)) return false;
    // The pictures were placed for another window size.
    if (extent != window) {
        destroySwapchain();
        return false;
    }
    try {
        const auto [result, index] = swapchain.acquireNextImage(timeout_ns, *acquired);
        if (result == vk::Result::eTimeout || result == vk::Result::eNotReady) return false;
        record(images[index], placed, background);
        submit(index);
        return present(index);
    } catch (const vk::OutOfDateKHRError&) {
        destroySwapchain();
        return false;
    }
}

Presenter::Presenter(const Gpu& gpu, VkSurfaceKHR surface)
    : impl_(guarded([&] { return std::make_unique<Impl>(gpu, surface); })) {}

Presenter::~Presenter() {
    try {
        impl_->gpu.device().waitIdle();
    } catch (const vk::Error&) {  // the device was lost: no work is pending any more
    }
}

void Presenter::setPicture(std::size_t id, std::uint32_t width, std::uint32_t height,
                           std::span<const std::uint8_t> rgba) {
    guarded([&] {
        Impl& me = *impl_;
        if (id >= me.pictures.size()) me.pictures.resize(id + 1);
        Impl::Picture& picture = me.pictures[id];
        if (!picture.image.hasSize({width, height})) {
            me.gpu.device().waitIdle();
            picture.image = GpuImage(
                me.gpu, isSrgb(me.format.format) ? vk::Format::eR8G8B8A8Srgb : vk::Format::eR8G8B8A8Unorm,
                {width, height, 1}, 1,
                vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eTransferSrc |
                    vk::ImageUsageFlagBits::eSampled);
            picture.pixels =
                Buffer(me.gpu, vk::DeviceSize(width) * height * 4, vk::BufferUsageFlagBits::eTransferSrc);
        }
        picture.pixels.write(rgba.data(), std::size_t(width) * height * 4);
        picture.changed = true;
    });
}

bool Presenter::show(std::uint32_t width, std::uint32_t height, std::span<const PlacedPicture> placed,
                     const std::array<float, 3>& background, std::uint64_t timeout_ns) {
    return guarded([&] { return impl_->show({width, height}, placed, background, timeout_ns); });
}

}  // namespace stylet::render
