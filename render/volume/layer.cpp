#include "render/volume/layer.h"

#include "render/gpu/image_states.h"

namespace stylet::render {
namespace {

const ImageState kLayerFresh{vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eFragmentShader, {}};
const ImageState kMarched{vk::ImageLayout::eGeneral, vk::PipelineStageFlagBits2::eComputeShader,
                          vk::AccessFlagBits2::eShaderStorageWrite};
const ImageState kLayerRead{vk::ImageLayout::eGeneral, vk::PipelineStageFlagBits2::eFragmentShader,
                            vk::AccessFlagBits2::eShaderStorageRead};

}  // namespace

bool VolumeLayer::reserve(vk::Extent2D size) {
    if (colour_.hasSize(size)) return false;
    const auto usage = vk::ImageUsageFlagBits::eStorage | vk::ImageUsageFlagBits::eTransferDst;
    colour_ = GpuImage(*gpu_, vk::Format::eR16G16B16A16Sfloat, {size.width, size.height, 1}, 2, usage);
    depth_ = GpuImage(*gpu_, vk::Format::eR32Sfloat, {size.width, size.height, 1}, 2, usage);
    return true;
}

void VolumeLayer::beginMarch(const vk::raii::CommandBuffer& commands) const {
    for (const GpuImage* image : {&colour_, &depth_})
        transition(commands, *image->handle, kColour, kLayerFresh, kMarched);
}

void VolumeLayer::upload(const vk::raii::CommandBuffer& commands, const Buffer& colour, const Buffer& depth,
                         vk::Extent2D size) const {
    const auto both = imagePart({size.width, size.height, 1}, 2);
    recordUpload(commands, colour, *colour_.handle, both, kLayerFresh, kLayerRead);
    recordUpload(commands, depth, *depth_.handle, both, kLayerFresh, kLayerRead);
}

void VolumeLayer::clear(const vk::raii::CommandBuffer& commands) const {
    const ImageState cleared{vk::ImageLayout::eGeneral, vk::PipelineStageFlagBits2::eClear,
                             vk::AccessFlagBits2::eTransferWrite};
    const vk::ImageSubresourceRange whole{kColour, 0, 1, 0, 2};
    for (const GpuImage* image : {&colour_, &depth_}) {
        transition(commands, *image->handle, kColour, kLayerFresh, cleared);
        commands.clearColorImage(*image->handle, vk::ImageLayout::eGeneral, vk::ClearColorValue{}, whole);
        transition(commands, *image->handle, kColour, cleared, kLayerRead);
    }
}

void VolumeLayer::endMarch(const vk::raii::CommandBuffer& commands) const {
    for (const GpuImage* image : {&colour_, &depth_})
        transition(commands, *image->handle, kColour, kMarched, kLayerRead);
}

}  // namespace stylet::render
