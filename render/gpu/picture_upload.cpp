#include "render/gpu/picture_upload.h"

#include <utility>

namespace stylet::render {

PictureUpload::PictureUpload(const Gpu& gpu, vk::Extent2D extent)
    : extent_(extent),
      staging_(gpu, vk::DeviceSize(extent.width) * extent.height * 4, vk::BufferUsageFlagBits::eTransferSrc),
      commands_(gpu) {}

void PictureUpload::write(vk::Image image, vk::Format format, const std::uint8_t* rgba) {
    staging_.write(rgba, staging_.size);
    if (format == vk::Format::eB8G8R8A8Srgb || format == vk::Format::eB8G8R8A8Unorm) {
        auto* const texels = static_cast<std::uint8_t*>(staging_.mapped);
        for (vk::DeviceSize i = 0; i < staging_.size; i += 4)
            std::swap(texels[i], texels[i + 2]);
    }
    const ImageState shown{
        vk::ImageLayout::eColorAttachmentOptimal, vk::PipelineStageFlagBits2::eAllCommands, {}};
    commands_.submitAndWait([&](const vk::raii::CommandBuffer& commands) {
        recordUpload(commands, staging_, image, imagePart({extent_.width, extent_.height, 1}), shown, shown);
    });
}

}  // namespace stylet::render
