// A patient classified in host memory, with the data that a volume march reads. Needs no GPU.
#pragma once

#include "render/frame/uniforms.h"
#include "render/volume/bricks.h"
#include "render/volume/march.h"

namespace stylet::test {

struct MarchCase {
    render::LookStyle look;
    Grid grid;
    std::vector<std::byte> rgba;  // layout as in classified.h
    render::BrickGrid bricks;
    std::vector<std::uint32_t> brick_distance;
    render::MarchVolume volume;

    MarchCase(const patient::Patient&, const render::LookStyle&);
    // Uses these texels instead of classifying a patient.
    MarchCase(const Grid&, std::vector<std::byte> rgba, const render::LookStyle&);

    // Uniforms for a patient whose own frame is the stage's frame.
    render::gpu::FrameUniforms frame(const std::array<render::View, 2>&, std::uint32_t width,
                                     std::uint32_t height, float step_voxels) const;
};

struct Layer {
    std::uint32_t width = 0, height = 0;
    std::vector<glm::vec4> colour;  // premultiplied linear, one eye after the other
    std::vector<float> depth_m;     // of the first surface; 0 = none
};

struct MarchRun {
    render::Skips skips = {};
    render::MarchPath path = render::MarchPath::widest;
    const render::DeformTables* deformation = nullptr;
    std::span<const float> mesh_depth = {};
};
Layer marchLayer(const MarchCase&, render::Workers&, const render::gpu::FrameUniforms&, const MarchRun& = {},
                 render::gpu::Counters* counted = nullptr);

// Peak signal to noise ratio [dB] over both eyes on black, as shown on a screen, and the largest channel
// difference (1 = full scale).
struct LayerDistance {
    double psnr_db = 0.0, worst = 0.0;
};
LayerDistance distance(const Layer&, const Layer&);

}  // namespace stylet::test
