// The fascia, first version: one closed smooth tube just inside the ribs, around the organs of chest and
// abdomen. It represents the endothoracic fascia above and the transversal fascia below. The paper draws it
// by hand as a tensor B-spline r(phi, h) (Mastmeyer et al. 2017).
#pragma once

#include <vector>

#include "app/modeller/image/voxel_tools.h"

namespace stylet::modeller {

// Inputs of the surface fit, all on one grid.
struct FasciaInput {
    const CtVolume& ct;
    const Mask& body;
    const Mask& bones;
    const Mask& organs;  // lungs and solid organs: the surface passes outside them
};

// The inner wall in polar coordinates about a vertical axis. Layout: radius_m[z * angles + phi].
struct WallSurface {
    Vec3 axis_m{0.0};  // x and y only
    double z_begin_m = 0.0, z_step_m = 0.004;
    int angles = 144, levels = 0;
    std::vector<double> radius_m;

    double radiusAt(double phi, double z_m) const;  // bilinear, periodic in phi
};

// Fits the wall to bones, and below the ribs to one muscle thickness inside the outer surface of the
// abdominal wall. Smooth in between. Stays outside organs and inside bones; where both touch, bones win.
WallSurface fitWall(const FasciaInput&);

// The enclosed volume: with organs, without bones, as one component without holes.
Mask insideWall(const WallSurface&, const FasciaInput&);

// Rasterises the boundary of `inside`, one voxel thick and 6-separating. Of each pair of face neighbours
// across the boundary, the outer voxel becomes fascia if it may be overwritten (`free`), else the inner
// one.
Mask rasteriseBoundary(const Mask& inside, const Mask& free);

}  // namespace stylet::modeller
