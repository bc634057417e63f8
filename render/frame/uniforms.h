// Computes the uniforms of the shaders from a scene's poses and angles.
#pragma once

#include <glm/mat4x4.hpp>

#include "render/frame/renderer.h"
#include "render/scene/frame_shared.h"
#include "render/volume/patient_volume.h"

namespace stylet::render {

// Sizes of one eye's picture and of its volume layer, in pixels.
struct FrameExtents {
    vk::Extent2D target, layer;
};
// `volume` may be null.
gpu::FrameUniforms frameUniforms(const RenderScene&, const std::array<View, 2>&, const RenderSettings&,
                                 const FrameExtents&, const PatientVolume* volume, const LookStyle& look);
// Size of the volume layer for a target: settings.layer_scale times the target's size. With
// settings.close_up, at most about three rays per voxel at the patient's nearest point.
vk::Extent2D layerExtent(const RenderScene&, const std::array<View, 2>&, const RenderSettings&,
                         vk::Extent2D target, const Grid&);
gpu::LookUniforms lookUniforms(const LookStyle&);

}  // namespace stylet::render
