#include "xr/registration/places.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace stylet::xr::registration {
namespace {

TEST(Places, AreSeparatedAndInsideTheCube) {
    const Cube cube{{0.1, 0.2, 0.3}, 0.04};
    const std::vector<Vec3> places = chooseTouchPlaces(cube, 100);
    EXPECT_EQ(places.size(), 34u);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const Vec3 off = glm::abs(places[i] - cube.centre_m);
        EXPECT_LE(std::max({off.x, off.y, off.z}), cube.half_m + 1e-12);
        for (std::size_t j = 0; j < i; ++j)
            EXPECT_GT(glm::distance(places[i], places[j]), 0.027);
    }
    // Four places form a tetrahedron, the largest distances for four corners of a cube.
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < i; ++j)
            EXPECT_NEAR(glm::distance(places[std::size_t(i)], places[std::size_t(j)]), 0.08 * std::sqrt(2.0),
                        1e-12);
}

TEST(Places, HaveNames) {
    const Cube cube;
    EXPECT_EQ(describePlace(cube, {-0.04, -0.04, -0.04}), "far left, low");
    EXPECT_EQ(describePlace(cube, {0.04, 0.04, 0.04}), "near right, high");
    EXPECT_EQ(describePlace(cube, {0.0, 0.04, 0.0}), "high");
    EXPECT_EQ(describePlace(cube, {0.0, 0.0, 0.0}), "the middle");
}

TEST(Places, TheNextPlaceWasNotTouchedBefore) {
    const std::vector<Vec3> places = chooseTouchPlaces(Cube{}, 8);
    EXPECT_EQ(nextPlace(places, {}, 0.02), places[0]);
    const std::vector<Vec3> at_the_first = {places[0] + Vec3(0.01, 0, 0)};
    EXPECT_EQ(nextPlace(places, at_the_first, 0.02), places[1]);
    EXPECT_EQ(nextPlace(places, at_the_first, 1.0), -places[0]) << "none is left: the farthest";
    EXPECT_EQ(octantsReached(Cube{}, places), 0xffu);
    EXPECT_EQ(octantsReached(Cube{}, at_the_first), 1u);
    const std::vector<Vec3> middle = {{0.0, 0.04, 0.04}};
    EXPECT_EQ(octantsReached(Cube{}, middle), 0u);
}

}  // namespace
}  // namespace stylet::xr::registration
