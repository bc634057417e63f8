// Conversion of points and rotations to Eigen types.
#pragma once

#include <Eigen/Dense>

#include "xr/registration/geometry.h"

namespace stylet::xr::registration {

inline Eigen::Vector3d eigen(const Vec3& v) {
    return {v.x, v.y, v.z};
}
inline Eigen::Matrix3d toMatrix(const Quat& q) {
    return Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
}

}  // namespace stylet::xr::registration
