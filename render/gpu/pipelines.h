// Creates pipelines for dynamic rendering from the few settings in which this module's pipelines differ.
#pragma once

#include <cstdint>
#include <span>

#include "render/gpu/gpu.h"

namespace stylet::render {

enum class Blend { none, over };  // over: premultiplied alpha
enum class DepthUse { none, test_and_write, test, write };

struct PipelineShape {
    std::span<const std::uint32_t> vertex = {}, fragment = {};
    std::span<const vk::VertexInputAttributeDescription> attributes = {};
    std::uint32_t vertex_stride = 0;
    std::span<const std::uint32_t> constants =
        {};  // 32-bit specialisation constants 0, 1, ... of the fragment shader
    vk::Format colour = vk::Format::eUndefined;  // undefined: only depth is drawn
    vk::Format depth = vk::Format::eUndefined;
    DepthUse depth_use = DepthUse::none;
    Blend blend = Blend::none;
    std::uint32_t view_mask = 0;
    bool cull_back = false;  // draw only counter-clockwise triangles
};

// Viewport and scissor are dynamic. Depth is reversed: near 1, far 0.
vk::raii::Pipeline makePipeline(const Gpu&, vk::PipelineLayout, const PipelineShape&);

// Workgroups of `size` that cover `items`.
constexpr std::uint32_t groupCount(int items, int size) {
    return (std::uint32_t(items) + std::uint32_t(size) - 1) / std::uint32_t(size);
}

// `constants`: 32-bit specialisation constants 0, 1, ...
vk::raii::Pipeline makeComputePipeline(const Gpu&, vk::PipelineLayout, std::span<const std::uint32_t> shader,
                                       std::span<const std::uint32_t> constants);

}  // namespace stylet::render
