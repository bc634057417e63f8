// Where to touch: places spread so that few of them tell most, and what has been reached so far.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "xr/registration/rigid.h"

namespace stylet::xr::registration {

// `count` places of the cube: its corners first, every other one before its neighbours, then the middles of
// its edges, of its faces, and those of the inner cube of half its size: 34 at most.
std::vector<Vec3> spreadPlaces(const Cube&, int count);

// In the device's axes as its user sees them (+x right, +y up, +z toward him): "far left, low".
std::string nameOfPlace(const Cube&, const Vec3& place_m);

// The first of the places with nothing of `taken` within `near_m`; none left: the one farthest from all.
Vec3 nextPlace(std::span<const Vec3> places_m, std::span<const Vec3> taken_m, double near_m);

// Which of the eight octants about the centre hold a point at least a quarter of the half away from the
// middle planes, as bits: x right 1, y up 2, z near 4.
unsigned octantsReached(const Cube&, std::span<const Vec3> points_m);

}  // namespace stylet::xr::registration
