// The fascia in its first form: one closed smooth tube just inside the ribs, around the chest's and belly's
// organs. Stands for the endothoracic fascia above and the transversal fascia below; the paper draws it by
// hand as a tensor B-spline r(phi, h) (Mastmeyer et al. 2017).
#pragma once

#include <vector>

#include "app/modeller/voxel_tools.h"

namespace stylet::modeller {

// What the surface is drawn from, all on one grid.
struct FasciaInput {
    const patient::CtVolume& ct;
    const Mask& body;
    const Mask& bones;
    const Mask& organs;  // lungs and solid organs: the surface passes outside them
};

// The inner wall in polar coordinates about a vertical axis: radius_m[z * angles + phi].
struct WallSurface {
    patient::Vec3 axis_m{0.0};  // x and y only
    double z_begin_m = 0.0, z_step_m = 0.004;
    int angles = 144, levels = 0;
    std::vector<double> radius_m;

    double radiusAt(double phi, double z_m) const;  // bilinear, periodic in phi
};

// Observed where bones and lungs show the wall and, below the ribs, one muscle's thickness inside the belly
// wall's outer surface; smooth in between; never inside an organ, never outside a bone.
WallSurface fitWall(const FasciaInput&);

// What the surface encloses: with the organs, without the bones, one component without holes.
Mask insideWall(const WallSurface&, const FasciaInput&);

// One voxel thick, 6-separating: of each pair of face neighbours across the boundary of `inside` one carries
// the fascia: the outer one where it may be overwritten (`free`), else the inner.
Mask rasteriseBoundary(const Mask& inside, const Mask& free);

}  // namespace stylet::modeller
