#include "render/scene/projection.h"

#include <cmath>

#include <glm/gtc/quaternion.hpp>

namespace stylet::render {

glm::dmat4 toMatrix(const Pose& pose) {
    glm::dmat4 m = glm::mat4_cast(pose.rotation);
    m[3] = glm::dvec4(pose.position_m, 1.0);
    return m;
}

glm::dmat4 clipFromEye(const View& view, double near_m, double far_m) {
    const double left = std::tan(double(view.angle_left)), right = std::tan(double(view.angle_right));
    const double up = std::tan(double(view.angle_up)), down = std::tan(double(view.angle_down));
    glm::dmat4 m(0.0);
    m[0][0] = 2.0 / (right - left);
    m[2][0] = (right + left) / (right - left);
    m[1][1] = -2.0 / (up - down);  // Vulkan's y points down
    m[2][1] = -(up + down) / (up - down);
    m[2][2] = near_m / (far_m - near_m);
    m[3][2] = near_m * far_m / (far_m - near_m);
    m[2][3] = -1.0;
    return m;
}

}  // namespace stylet::render
