// From a scene's poses and angles to what the shaders read.
#pragma once

#include <glm/mat4x4.hpp>

#include "render/frame_shared.h"
#include "render/patient_volume.h"
#include "render/renderer.h"

namespace stylet::render {

glm::dmat4 matrixOf(const Pose&);

// Asymmetric perspective of an OpenXR view onto Vulkan's clip space, depth reversed: 1 at `near_m`, 0 at
// `far_m`.
glm::dmat4 clipFromEye(const View&, double near_m, double far_m);

// `volume` may be null.
gpu::FrameUniforms frameUniforms(const RenderScene&, const std::array<View, 2>&, const RenderSettings&,
                                 std::uint32_t width, std::uint32_t height, const PatientVolume* volume,
                                 const LookStyle& look);
gpu::LookUniforms lookUniforms(const LookStyle&);

}  // namespace stylet::render
