#include "render/volume/table_image.h"

#include <cassert>
#include <cstring>

#include <glm/gtc/packing.hpp>

#include "render/gpu/image_states.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace stylet::render {
namespace {

#if defined(__x86_64__)
__attribute__((target("avx,f16c"))) void packHalvesWide(const glm::vec4* from, std::size_t count,
                                                        std::uint64_t* to) {
    for (std::size_t i = 0; i < count; ++i)
        _mm_storel_epi64(reinterpret_cast<__m128i*>(to + i),
                         _mm_cvtps_ph(_mm_loadu_ps(&from[i].x), _MM_FROUND_TO_NEAREST_INT));
}
#endif

const ImageState kTableFresh{vk::ImageLayout::eUndefined, vk::PipelineStageFlagBits2::eComputeShader, {}};
std::size_t texelCount(const vk::Extent3D& e) {
    return std::size_t(e.width) * e.height * e.depth;
}

}  // namespace

void packHalves(const glm::vec4* from, std::size_t count, std::uint64_t* to) {
#if defined(__x86_64__)
    static const bool wide = __builtin_cpu_supports("avx") && __builtin_cpu_supports("f16c");
    if (wide) return packHalvesWide(from, count, to);
#endif
    for (std::size_t i = 0; i < count; ++i)
        to[i] = glm::packHalf4x16(from[i]);
}

TableImage::TableImage(const Gpu& gpu, const Index3& dims)
    : image_(makeVolumeImage(gpu, kTableFormat, dims)),
      staging_(gpu, texelCount(image_.extent) * sizeof(std::uint64_t),
               vk::BufferUsageFlagBits::eTransferSrc) {
    std::memset(staging_.mapped, 0, std::size_t(staging_.size));
}

void TableImage::write(const std::vector<glm::vec4>& table, Workers& workers) {
    assert(table.size() == texelCount(image_.extent));
    const std::size_t slice = std::size_t(image_.extent.width) * image_.extent.height;
    workers.run(image_.extent.depth, [&](std::size_t z, int) {
        packHalves(table.data() + z * slice, slice, static_cast<std::uint64_t*>(staging_.mapped) + z * slice);
    });
    stale_ = true;
}

void TableImage::recordUpload(const vk::raii::CommandBuffer& commands) {
    if (!stale_) return;
    render::recordUpload(commands, staging_, *image_.handle, imagePart(image_.extent), kTableFresh,
                         kComputeRead);
    stale_ = false;
}

}  // namespace stylet::render
