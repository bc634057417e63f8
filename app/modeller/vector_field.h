// Displacement and velocity fields on a voxel grid, and the way between the two.
// Based on Arsigny et al. 2006 (a displacement is the exponential of a stationary velocity field).
#pragma once

#include <glm/vec3.hpp>

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

using VectorField = patient::Volume<glm::vec3>;  // metres

// Linear between voxels; beyond the grid the border's value.
patient::Vec3 vectorAt(const VectorField&, const patient::Vec3& p_m);
// The same of an image; `outside` beyond the grid.
float valueAt(const FloatVolume&, const patient::Vec3& p_m, float outside);

// exp of a velocity field, as a displacement, by scaling and squaring.
VectorField exponential(const VectorField& velocity);
// The velocity whose exponential is `displacement`, which must be invertible: v <- v + ((id + u) o exp(-v) -
// id). Returns the largest mismatch left through `error_m`.
VectorField logarithm(const VectorField& displacement, double& error_m);

// The image as it is at p + displacement(p).
FloatVolume warped(const FloatVolume&, const VectorField& displacement, float outside);

}  // namespace stylet::modeller
