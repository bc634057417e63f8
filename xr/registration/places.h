// Where to touch: places spread so that few of them determine the fit well, and the coverage reached so
// far.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "xr/registration/rigid.h"

namespace stylet::xr::registration {

// Returns up to `count` places of the cube, at most 34. First the corners, four non-adjacent ones before
// the others; then the centres of the edges and of the faces; then the corners of a cube of half the size.
std::vector<Vec3> chooseTouchPlaces(const Cube&, int count);

// Name of a place as seen by the device's user (+x right, +y up, +z towards the user): "far left, low".
std::string describePlace(const Cube&, const Vec3& place_m);

// Returns the first place that has no point of `touched_m` within `near_m`. If there is none, returns the
// place farthest from all of them.
Vec3 nextPlace(std::span<const Vec3> places_m, std::span<const Vec3> touched_m, double near_m);

// Octants of the cube that contain a point, as a mask of 8 bits. Bit index: 1 for x right, plus 2 for y up,
// plus 4 for z near. Points closer to a middle plane than a quarter of half_m do not count.
unsigned octantsReached(const Cube&, std::span<const Vec3> points_m);

}  // namespace stylet::xr::registration
