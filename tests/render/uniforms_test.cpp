#include "render/frame/uniforms.h"

#include "render/scene/projection.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stylet::render {
namespace {

// The corners of an OpenXR view with four different angles must map to the corners of Vulkan's clip space.
TEST(ClipFromEye, MapsTheFieldOfViewOntoTheTarget) {
    View view;
    view.angle_left = -0.9f, view.angle_right = 0.6f, view.angle_up = 0.5f, view.angle_down = -0.8f;
    const glm::dmat4 clip = clipFromEye(view, 0.05, 20.0);
    const auto ndc = [&](double angle_x, double angle_y, double depth_m) {
        const glm::dvec4 p =
            clip * glm::dvec4(std::tan(angle_x) * depth_m, std::tan(angle_y) * depth_m, -depth_m, 1.0);
        return glm::dvec3(p) / p.w;
    };
    for (const double depth_m : {0.05, 1.0, 20.0}) {
        const glm::dvec3 top_left = ndc(double(view.angle_left), double(view.angle_up), depth_m);
        EXPECT_NEAR(top_left.x, -1.0, 1e-12);
        EXPECT_NEAR(top_left.y, -1.0, 1e-12);  // Vulkan: -1 is the top row
        const glm::dvec3 low_right = ndc(double(view.angle_right), double(view.angle_down), depth_m);
        EXPECT_NEAR(low_right.x, 1.0, 1e-12);
        EXPECT_NEAR(low_right.y, 1.0, 1e-12);
    }
    EXPECT_NEAR(ndc(0, 0, 0.05).z, 1.0, 1e-12);
    EXPECT_NEAR(ndc(0, 0, 20.0).z, 0.0, 1e-12);
    // The inverse depth mapping of meshDepth() in bindings.glsl.
    const double d = ndc(0, 0, 0.7).z;
    EXPECT_NEAR(0.05 * 20.0 / (0.05 + d * (20.0 - 0.05)), 0.7, 1e-12);
}

}  // namespace
}  // namespace stylet::render
