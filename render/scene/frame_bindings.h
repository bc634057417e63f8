// Descriptor bindings shared by all pipelines of a frame: the C++ side of bindings.glsl.
#pragma once

#include <array>
#include <cstdint>

#include "render/gpu/gpu.h"

namespace stylet::render {

// Binding numbers, as in bindings.glsl.
enum class Binding : std::uint32_t {
    frame,
    look,
    classified,
    mesh_depth,
    bricks,
    deform_inside,
    counters,
    deform_outside,
    layer_colour,
    layer_depth,
    tool_moved,
    room,
    environment,
    lamp_shadow,
    screens
};

inline constexpr std::array kFrameBindings{
    vk::DescriptorType::eUniformBuffer,        vk::DescriptorType::eUniformBuffer,
    vk::DescriptorType::eCombinedImageSampler, vk::DescriptorType::eCombinedImageSampler,
    vk::DescriptorType::eStorageBuffer,        vk::DescriptorType::eCombinedImageSampler,
    vk::DescriptorType::eStorageBuffer,        vk::DescriptorType::eCombinedImageSampler,
    vk::DescriptorType::eStorageImage,         vk::DescriptorType::eStorageImage,
    vk::DescriptorType::eCombinedImageSampler, vk::DescriptorType::eUniformBuffer,
    vk::DescriptorType::eCombinedImageSampler, vk::DescriptorType::eCombinedImageSampler,
    vk::DescriptorType::eCombinedImageSampler};

}  // namespace stylet::render
