#include "tests/render/volume/march_case.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/packing.hpp>

#include "render/volume/classified.h"

namespace stylet::test {

using namespace render;

namespace {

std::vector<std::byte> classify(const patient::Patient& patient, const LookStyle& look) {
    std::vector<std::byte> rgba(patient.grid().voxelCount() * 4);
    classifyPlanes(patient, makePalette(look, patient), 0, patient.grid().dims.z, rgba.data(), 2);
    return rgba;
}

float onScreen(float linear) {
    const float c = std::clamp(linear, 0.0f, 1.0f);
    return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
}

}  // namespace

MarchCase::MarchCase(const patient::Patient& patient, const LookStyle& style)
    : MarchCase(patient.grid(), classify(patient, style), style) {}

MarchCase::MarchCase(const Grid& its_grid, std::vector<std::byte> texels, const LookStyle& style)
    : look(style), grid(its_grid), rgba(std::move(texels)), bricks(grid.dims), volume(grid.dims) {
    markOccupied(bricks, grid.dims, 0, grid.dims.z, rgba.data());
    brick_distance = leapDistances(bricks);
    volume.setPlanes(0, grid.dims.z, rgba.data());
}

gpu::FrameUniforms MarchCase::frame(const std::array<View, 2>& views, std::uint32_t width,
                                    std::uint32_t height, float step_voxels) const {
    gpu::FrameUniforms frame =
        frameUniforms({}, views, {}, {{width, height}, {width, height}}, nullptr, look);
    frame.grid_origin = glm::vec4(glm::vec3(grid.origin_m), 1.0f);
    frame.grid_spacing = glm::vec4(glm::vec3(grid.spacing_m), step_voxels);
    frame.grid_dims = glm::vec4(glm::vec3(grid.dims), float(look.full_extinction_per_m));
    frame.layer = {float(width), float(height), 0.0f, 0.0f};
    frame.brick_dims = glm::vec4(glm::vec3(bricks.dims), 0.0f);
    return frame;
}

Layer marchLayer(const MarchCase& from, Workers& workers, const gpu::FrameUniforms& frame,
                 const MarchRun& run, gpu::Counters* counted) {
    Layer layer{std::uint32_t(frame.layer.x), std::uint32_t(frame.layer.y), {}, {}};
    std::vector<std::uint64_t> halves(std::size_t(2) * layer.width * layer.height);
    layer.depth_m.resize(halves.size());
    const gpu::LookUniforms look = lookUniforms(from.look);
    const gpu::Counters counters = march(workers,
                                         {.frame = frame,
                                          .look = look,
                                          .volume = from.volume,
                                          .brick_distance = from.brick_distance,
                                          .deformation = run.deformation,
                                          .mesh_depth = run.mesh_depth,
                                          .skips = run.skips,
                                          .count = counted != nullptr},
                                         {.colour = halves.data(), .depth = layer.depth_m.data()}, run.path);
    if (counted) *counted = counters;
    layer.colour.reserve(halves.size());
    for (const std::uint64_t half : halves)
        layer.colour.push_back(glm::unpackHalf4x16(half));
    return layer;
}

LayerDistance distance(const Layer& a, const Layer& b) {
    LayerDistance d;
    double squares = 0.0;
    for (std::size_t i = 0; i < a.colour.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double off = double(onScreen(a.colour[i][c])) - double(onScreen(b.colour[i][c]));
            squares += off * off;
            d.worst = std::max(d.worst, std::fabs(off));
        }
    d.psnr_db = 10.0 * std::log10(3.0 * double(a.colour.size()) / squares);
    return d;
}

}  // namespace stylet::test
