#include "render/volume/march_layer.h"

#include "render/gpu/image_states.h"

namespace stylet::render {

void MarchLayer::reserve(vk::Extent2D target) {
    if (target_ == target) return;
    const vk::DeviceSize pixels = vk::DeviceSize(2) * target.width * target.height;
    mesh_depth_ = Buffer(*gpu_, pixels * sizeof(float), vk::BufferUsageFlagBits::eTransferDst);
    colour_ = Buffer(*gpu_, pixels * sizeof(std::uint64_t), vk::BufferUsageFlagBits::eTransferSrc);
    depth_ = Buffer(*gpu_, pixels * sizeof(float), vk::BufferUsageFlagBits::eTransferSrc);
    target_ = target;
}

void MarchLayer::readDepth(const vk::raii::CommandBuffer& commands, const GpuImage& depth,
                           const ImageState& state) const {
    transition(commands, *depth.handle, vk::ImageAspectFlagBits::eDepth, state, kCopyRead);
    commands.copyImageToBuffer(
        *depth.handle, kCopyRead.layout, *mesh_depth_.handle,
        imagePart({target_.width, target_.height, 1}, 2, vk::ImageAspectFlagBits::eDepth));
    transition(commands, *depth.handle, vk::ImageAspectFlagBits::eDepth, kCopyRead, state);
    memoryBarrier(commands, kCopyWrites, kHostReads);
}

gpu::Counters MarchLayer::march(const gpu::FrameUniforms& frame, const gpu::LookUniforms& look,
                                const PatientVolume& volume, const DeformedPatient& deformed,
                                const RenderSettings& settings) {
    const std::size_t pixels = std::size_t(2) * target_.width * target_.height;
    return render::march(
        workers_,
        {.frame = frame,
         .look = look,
         .volume = volume.onHost(),
         .brick_distance = volume.brickDistances(),
         .deformation = deformed.still() ? nullptr : &deformed.tables(),
         .tool = deformed.tool(),
         .mesh_depth = {static_cast<const float*>(mesh_depth_.mapped), pixels},
         .skips = settings.skips,
         .count = settings.count},
        {.colour = static_cast<std::uint64_t*>(colour_.mapped), .depth = static_cast<float*>(depth_.mapped)});
}

void MarchLayer::upload(const vk::raii::CommandBuffer& commands, const VolumeLayer& layer,
                        vk::Extent2D size) const {
    layer.upload(commands, colour_, depth_, size);
}

}  // namespace stylet::render
