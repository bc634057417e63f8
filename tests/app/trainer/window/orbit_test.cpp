#include "app/trainer/window/orbit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace stylet::trainer {
namespace {

Vec3 eyeOf(const Orbit& o) {
    return orbitView(o, 1.0).stage_from_eye.position_m;
}

TEST(Orbit, ItLooksAtItsMiddleFromItsDistanceUpright) {
    const Orbit o{{0.1, 1.0, -0.4}, 0.7, 0.5, 1.3};
    const render::View view = orbitView(o, 2.0);
    EXPECT_NEAR(glm::distance(view.stage_from_eye.position_m, o.middle_m), 1.3, 1e-12);
    const Vec3 seen = view.stage_from_eye.inverse() * o.middle_m;
    EXPECT_NEAR(seen.x, 0.0, 1e-12);
    EXPECT_NEAR(seen.y, 0.0, 1e-12);
    EXPECT_NEAR(seen.z, -1.3, 1e-12);
    EXPECT_NEAR(view.stage_from_eye.direction({1.0, 0.0, 0.0}).y, 0.0, 1e-12) << "the horizon is level";
    EXPECT_NEAR(std::tan(view.angle_right) / std::tan(view.angle_up), 2.0, 1e-6) << "pixels are square";
}

TEST(Orbit, DragToTheRightMovesTheCameraLeft) {
    Orbit o{{0.0, 1.0, 0.0}, 0.0, 0.0, 1.0};
    EXPECT_NEAR(eyeOf(o).z, 1.0, 1e-12);
    turn(o, 0.5, 0.0);  // the scene follows the pointer
    EXPECT_NEAR(eyeOf(o).x, -1.0, 1e-12);
    for (int i = 0; i < 50; ++i)
        turn(o, 0.0, -0.3);
    EXPECT_DOUBLE_EQ(o.elevation_rad, kMaxElevation_rad) << "never over the top";
    EXPECT_LT(std::abs(o.azimuth_rad), std::numbers::pi + 1e-9);
}

TEST(Orbit, PanByThePictureHeightMovesByTheVisibleHeight) {
    Orbit o{{0.0, 1.0, 0.0}, 0.3, 0.4, 2.0};
    const Orbit before = o;
    pan(o, 0.0, 1.0);
    EXPECT_NEAR(glm::distance(o.middle_m, before.middle_m), 4.0 * std::tan(kOrbitHalfHeight_rad), 1e-12);
    // The former centre is now at the upper edge.
    const render::View view = orbitView(o, 1.0);
    const Vec3 seen = view.stage_from_eye.inverse() * before.middle_m;
    EXPECT_NEAR(seen.y / -seen.z, 2.0 * std::tan(double(view.angle_up)), 1e-6);
}

TEST(Orbit, TheWheelStopsBeforeThePatientAndTheWalls) {
    Orbit o;
    zoom(o, 1.0);
    EXPECT_LT(o.distance_m, 1.0);
    zoom(o, 100.0);
    EXPECT_EQ(o.distance_m, kMinDistance_m);
    zoom(o, -100.0);
    EXPECT_EQ(o.distance_m, kMaxDistance_m);
}

}  // namespace
}  // namespace stylet::trainer
