#include "render/room/screens.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include "render/gpu/image_states.h"

namespace stylet::render {
namespace {

constexpr vk::DeviceSize kLayerBytes = vk::DeviceSize(kMaxScreenPixels) * kMaxScreenPixels * 4;

}  // namespace

Screens::Screens(const Gpu& gpu)
    : image_(gpu, vk::Format::eR8G8B8A8Srgb, {kMaxScreenPixels, kMaxScreenPixels, 1}, gpu::kScreens,
             vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferDst),
      staging_(gpu, gpu::kScreens * kLayerBytes, vk::BufferUsageFlagBits::eTransferSrc) {
    submitAndWait(gpu, [&](const vk::raii::CommandBuffer& buffer) {
        transition(buffer, *image_.handle, kColour, kFreshImage, kFragmentRead);
    });
}

void Screens::update(const RenderScene& scene, gpu::RoomUniforms& room) {
    const std::array pictures{&scene.ultrasound_screen, &scene.xray_screen, &scene.monitor_screen};
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const ScreenPicture& picture = *pictures[i];
        Layer& layer = layers_[i];
        layer.changed = false;
        const bool shown = picture.width > 0 && picture.height > 0 && picture.rgba;
        room.screens[i] = {float(picture.width) / kMaxScreenPixels, float(picture.height) / kMaxScreenPixels,
                           shown ? 1.0f : 0.0f, picture.beneath ? 1.0f : 0.0f};
        if (!shown || (layer.revision == picture.revision && layer.width == picture.width &&
                       layer.height == picture.height))
            continue;
        assert(picture.width <= kMaxScreenPixels && picture.height <= kMaxScreenPixels);
        staging_.write(picture.rgba, std::size_t(picture.width) * std::size_t(picture.height) * 4,
                       i * kLayerBytes);
        layer = {picture.revision, picture.width, picture.height, true};
    }
}

void Screens::record(const vk::raii::CommandBuffer& buffer) const {
    const bool any = std::any_of(layers_.begin(), layers_.end(), [](const Layer& l) { return l.changed; });
    if (!any) return;
    transition(buffer, *image_.handle, kColour, kFragmentRead, kCopyWritten);
    for (std::uint32_t i = 0; i < layers_.size(); ++i) {
        if (!layers_[i].changed) continue;
        auto part = imagePart({std::uint32_t(layers_[i].width), std::uint32_t(layers_[i].height), 1});
        part.bufferOffset = i * kLayerBytes;
        part.imageSubresource.baseArrayLayer = i;
        buffer.copyBufferToImage(*staging_.handle, *image_.handle, kCopyWritten.layout, part);
    }
    transition(buffer, *image_.handle, kColour, kCopyWritten, kFragmentRead);
}

}  // namespace stylet::render
