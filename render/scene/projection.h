// Vectors for shaders, matrices of poses and of the eyes' views.
#pragma once

#include <glm/mat4x4.hpp>

#include "render/scene/scene.h"

namespace stylet::render {

glm::dmat4 toMatrix(const Pose&);
inline glm::vec4 toVec4(const Vec3& v, double w = 0.0) {
    return {glm::vec3(v), float(w)};
}

// Asymmetric perspective projection of an OpenXR view to Vulkan's clip space. Depth is reversed: 1 at
// `near_m`, 0 at `far_m`.
glm::dmat4 clipFromEye(const View&, double near_m, double far_m);

}  // namespace stylet::render
