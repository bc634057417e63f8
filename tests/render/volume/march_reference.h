// The volume pass according to its definition: one ray, double precision, constant step size, no skips.
// Shares no code with march.cpp or volume.comp.
#pragma once

#include <functional>

#include "tests/render/volume/march_case.h"

namespace stylet::test {

struct ReferenceRay {
    glm::dvec3 light{0.0};  // premultiplied linear, before highlight compression
    double opacity = 0.0;
    double depth_m = 0.0;  // along the eye's -z, where half of the light is absorbed; 0 = never
};

struct ReferenceSettings {
    double step_voxels = 0.05;
    const render::DeformTables* deformation = nullptr;
    double mesh_depth_m = 1e9;
};

// The ray through `at`, in shares of the picture from its top left corner.
ReferenceRay referenceRay(const MarchCase&, const render::gpu::FrameUniforms&, int eye, const glm::dvec2& at,
                          const ReferenceSettings& = {});

// Every pixel of both eyes, in the format of march().
Layer referenceLayer(const MarchCase&, const render::gpu::FrameUniforms&, const ReferenceSettings& = {});

}  // namespace stylet::test
