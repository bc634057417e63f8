// The volume pass on the processor, for machines without a GPU: the same rays, samples and light as
// volume.comp, from the same structs. One ray at a time; a vector holds the eight corners' colours of one
// look-up.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/frame_shared.h"
#include "render/scene.h"
#include "render/volume/deform.h"
#include "render/volume/workers.h"

namespace stylet::render {

// The classified volume (classified.h) as the march reads it: within a border of clear texels, so that no
// look-up asks where the volume ends.
class MarchVolume {
  public:
    MarchVolume() = default;
    explicit MarchVolume(const patient::Index3& dims);
    // RGBA8 texels of planes [z0, z1).
    void setPlanes(int z0, int z1, const std::byte* rgba);

    const patient::Index3& dims() const { return dims_; }
    // Of the texel at (-1, -1, -1); rows and planes are `row` and `plane` texels apart.
    const std::uint32_t* texels() const { return texels_.get(); }
    std::size_t row() const { return std::size_t(dims_.x) + 3; }
    std::size_t plane() const { return row() * (std::size_t(dims_.y) + 3); }

  private:
    struct Free {
        void operator()(std::uint32_t* p) const;
    };
    patient::Index3 dims_{0};
    std::unique_ptr<std::uint32_t[], Free> texels_;
};

// What a frame's march reads. Everything outlives the call.
struct MarchInput {
    const gpu::FrameUniforms& frame;
    const gpu::LookUniforms& look;
    const MarchVolume& volume;
    std::span<const std::uint32_t> brick_distance;
    const DeformTables* deformation = nullptr;         // null: the patient is as the CT saw him
    const patient::DisplacementTable* tool = nullptr;  // null: nothing presses
    std::span<const float> mesh_depth;  // reversed, as large as the target, eye after eye; empty: no mesh
    Skips skips = {};
    bool count = false;
    std::uint32_t eyes = 2;
};

struct MarchOutput {
    std::uint64_t* colour = nullptr;  // RGBA16F, premultiplied linear, as large as the layer, eye after eye
    float* depth = nullptr;           // m along the eye's -z; 0 = nothing that hides
};

enum class MarchPath : std::uint8_t { widest, portable };

// AVX2, FMA and F16C where the processor has them. Frame thread; no allocation.
gpu::Counters march(Workers&, const MarchInput&, const MarchOutput&, MarchPath = MarchPath::widest);

}  // namespace stylet::render
