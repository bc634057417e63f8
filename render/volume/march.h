// The volume pass on the processor, for machines without a GPU. Rays, samples, light and structs are those
// of volume.comp. It marches one ray at a time; a SIMD vector holds the eight corner colours of one
// look-up.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/scene/frame_shared.h"
#include "render/scene/scene.h"
#include "render/volume/deform.h"
#include "render/volume/workers.h"

namespace stylet::render {

// The classified volume (classified.h) for the march, with a border of clear texels, so that no look-up
// needs a bounds check.
class MarchVolume {
  public:
    MarchVolume() = default;
    explicit MarchVolume(const Index3& dims);
    // Sets planes [z0, z1) from RGBA8 texels.
    void setPlanes(int z0, int z1, const std::byte* rgba);

    const Index3& dims() const { return dims_; }
    // Address of the texel at (-1, -1, -1). Rows and planes are row() and plane() texels apart.
    const std::uint32_t* texels() const { return texels_.get(); }
    std::size_t row() const { return std::size_t(dims_.x) + 3; }
    std::size_t plane() const { return row() * (std::size_t(dims_.y) + 3); }

  private:
    struct Free {
        void operator()(std::uint32_t* p) const;
    };
    Index3 dims_{0};
    std::unique_ptr<std::uint32_t[], Free> texels_;
};

// Input of a frame's march. Everything must outlive the call.
struct MarchInput {
    const gpu::FrameUniforms& frame;
    const gpu::LookUniforms& look;
    const MarchVolume& volume;
    std::span<const std::uint32_t> brick_distance;
    const DeformTables* deformation = nullptr;         // null: the patient is as scanned
    const patient::DisplacementTable* tool = nullptr;  // null: no tool presses
    std::span<const float> mesh_depth;  // reversed depth, of the target's size, eye after eye; empty: no mesh
    Skips skips = {};
    bool count = false;
    std::uint32_t eyes = 2;
};

struct MarchOutput {
    std::uint64_t* colour = nullptr;  // RGBA16F, premultiplied linear, of the layer's size, eye after eye
    float* depth = nullptr;           // m along the eye's -z; 0: no opaque surface
};

enum class MarchPath : std::uint8_t { widest, portable };

// Frame thread. Allocates nothing. Uses AVX2, FMA and F16C where the processor has them.
gpu::Counters march(Workers&, const MarchInput&, const MarchOutput&, MarchPath = MarchPath::widest);

}  // namespace stylet::render
