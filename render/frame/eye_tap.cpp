#include "render/frame/eye_tap.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "render/gpu/guarded.h"
#include "render/gpu/image_states.h"

namespace stylet::render {
namespace {

constexpr std::uint64_t kTimeout_ns = 1'000'000'000;
constexpr vk::Format kFormat = vk::Format::eR8G8B8A8Srgb;

vk::Extent2D shrunk(const StereoTarget& target, std::uint32_t max_pixels) {
    const std::uint32_t longer = std::max(target.width, target.height);
    if (longer <= max_pixels) return {target.width, target.height};
    const auto edge = [&](std::uint32_t pixels) {
        return std::max(1u, std::uint32_t(std::uint64_t(pixels) * max_pixels / longer));
    };
    return {edge(target.width), edge(target.height)};
}

std::array<vk::Offset3D, 2> whole(vk::Extent2D extent) {
    return {vk::Offset3D{0, 0, 0}, vk::Offset3D{int(extent.width), int(extent.height), 1}};
}

}  // namespace

struct EyeTap::Impl {
    struct Copy {
        GpuImage small;
        Buffer pixels;
        vk::raii::CommandBuffer commands = nullptr;
        vk::raii::Fence done = nullptr;
        bool pending = false;
        std::uint64_t number = 0;  // 0: never submitted
        std::uint64_t tag = 0;
    };

    explicit Impl(const Gpu& g);
    bool finished(Copy&);
    void size(Copy&, vk::Extent2D);
    void record(const Copy&, const StereoTarget&, int eye) const;

    const Gpu& gpu;
    vk::raii::CommandPool pool;
    std::array<Copy, 2> copies;
    std::uint64_t submitted_count = 0, last_read = 0;
};

EyeTap::Impl::Impl(const Gpu& g)
    : gpu(g),
      pool(gpu.device(),
           vk::CommandPoolCreateInfo{.flags = vk::CommandPoolCreateFlagBits::eTransient |
                                              vk::CommandPoolCreateFlagBits::eResetCommandBuffer,
                                     .queueFamilyIndex = gpu.queueFamily()}) {
    for (Copy& copy : copies) {
        copy.commands = makeCommandBuffer(gpu, pool);
        copy.done = gpu.device().createFence({});
    }
}

bool EyeTap::Impl::finished(Copy& copy) {
    if (copy.pending && copy.done.getStatus() == vk::Result::eSuccess) {
        gpu.device().resetFences(*copy.done);
        copy.pending = false;
    }
    return !copy.pending;
}

void EyeTap::Impl::size(Copy& copy, vk::Extent2D wanted) {
    if (copy.small.hasSize(wanted)) return;
    copy.small = GpuImage(gpu, kFormat, {wanted.width, wanted.height, 1}, 1,
                          vk::ImageUsageFlagBits::eTransferDst | vk::ImageUsageFlagBits::eTransferSrc |
                              vk::ImageUsageFlagBits::eSampled);
    copy.pixels = makeReadBuffer(gpu, vk::DeviceSize(wanted.width) * wanted.height * 4,
                                 vk::BufferUsageFlagBits::eTransferDst);
}

void EyeTap::Impl::record(const Copy& copy, const StereoTarget& target, int eye) const {
    const vk::raii::CommandBuffer& commands = copy.commands;
    const vk::Image small = *copy.small.handle;
    const vk::Extent2D extent{copy.small.extent.width, copy.small.extent.height};
    commands.begin({.flags = vk::CommandBufferUsageFlagBits::eOneTimeSubmit});
    transition(commands, target.image, kColour, kColourDrawn, kTransferRead);
    transition(commands, small, kColour, kTransferFresh, kTransferWritten);
    const vk::ImageBlit scaled{.srcSubresource = {kColour, 0, std::uint32_t(eye), 1},
                               .srcOffsets = whole({target.width, target.height}),
                               .dstSubresource = {kColour, 0, 0, 1},
                               .dstOffsets = whole(extent)};
    commands.blitImage(target.image, kTransferRead.layout, small, kTransferWritten.layout, scaled,
                       vk::Filter::eLinear);
    transition(commands, target.image, kColour, kTransferRead, kColourDrawn);
    transition(commands, small, kColour, kTransferWritten, kTransferRead);
    commands.copyImageToBuffer(small, kTransferRead.layout, *copy.pixels.handle,
                               imagePart(copy.small.extent));
    memoryBarrier(commands, {vk::PipelineStageFlagBits2::eTransfer, vk::AccessFlagBits2::eTransferWrite},
                  kHostReads);
    commands.end();
}

EyeTap::EyeTap(const Gpu& gpu) : impl_(guarded([&] { return std::make_unique<Impl>(gpu); })) {}

EyeTap::~EyeTap() {
    for (const Impl::Copy& copy : impl_->copies) {
        if (!copy.pending) continue;
        try {
            (void)impl_->gpu.device().waitForFences(*copy.done, true, kTimeout_ns);
        } catch (const vk::Error&) {  // the device was lost: no copy is pending any more
        }
    }
}

bool EyeTap::submitCopy(const StereoTarget& target, int eye, std::uint32_t max_pixels, std::uint64_t tag) {
    return guarded([&] {
        Impl& me = *impl_;
        Impl::Copy* free = nullptr;
        for (Impl::Copy& copy : me.copies)
            if (me.finished(copy) && (!free || copy.number < free->number)) free = &copy;
        if (!free) return false;
        free->tag = tag;
        me.size(*free, shrunk(target, max_pixels));
        me.record(*free, target, eye);
        const vk::CommandBufferSubmitInfo info{.commandBuffer = *free->commands};
        me.gpu.queue().submit2(vk::SubmitInfo2{.commandBufferInfoCount = 1, .pCommandBufferInfos = &info},
                               *free->done);
        free->pending = true;
        free->number = ++me.submitted_count;
        return true;
    });
}

std::optional<std::uint64_t> EyeTap::read(Image& image) {
    return guarded([&]() -> std::optional<std::uint64_t> {
        Impl& me = *impl_;
        Impl::Copy* newest = nullptr;
        for (Impl::Copy& copy : me.copies)
            if (me.finished(copy) && copy.number > me.last_read && (!newest || copy.number > newest->number))
                newest = &copy;
        if (!newest) return std::nullopt;
        me.last_read = newest->number;
        image.width = newest->small.extent.width, image.height = newest->small.extent.height;
        image.rgba.resize(std::size_t(image.width) * image.height * 4);
        std::memcpy(image.rgba.data(), newest->pixels.mapped, image.rgba.size());
        return newest->tag;
    });
}

}  // namespace stylet::render
