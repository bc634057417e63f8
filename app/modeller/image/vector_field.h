// Displacement and velocity fields on a voxel grid, and the conversion between them.
// Based on Arsigny et al. 2006 (a displacement is the exponential of a stationary velocity field).
#pragma once

#include <glm/vec3.hpp>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

using VectorField = Volume<glm::vec3>;  // metres

// Trilinear; clamped to the border outside the grid.
Vec3 vectorAt(const VectorField&, const Vec3& p_m);
// The same for an image, but returns `outside` outside the grid.
float valueAt(const FloatVolume&, const Vec3& p_m, float outside);

// Exponential of a velocity field as a displacement, by scaling and squaring.
VectorField exponential(const VectorField& velocity);
// Returns the velocity field v whose exponential is the displacement u. The map x -> x + u(x) must be
// invertible. Iterates v <- v + ((id + u) o exp(-v) - id), where id is the identity map and o is composition.
// Stores the largest remaining mismatch in `error_m`.
VectorField logarithm(const VectorField& displacement, double& error_m);

// Samples the image at p + displacement(p).
FloatVolume warped(const FloatVolume&, const VectorField& displacement, float outside);

}  // namespace stylet::modeller
