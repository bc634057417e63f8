// The inner wall of chest and abdomen as a grid of radii: one closed smooth tube just inside the ribs, around
// the organs. It is the first estimate from which the fascia is searched (fascia_surface.h).
#pragma once

#include <algorithm>
#include <numbers>
#include <vector>

#include "app/modeller/image/voxel_tools.h"
#include "patient/tissue/tissue.h"

namespace stylet::modeller {

inline constexpr double kFullTurn = 2.0 * std::numbers::pi;  // [rad]

// Inputs of the surface fit, all on one grid.
struct FasciaInput {
    const CtVolume& ct;
    const Mask& body;
    const Mask& bones;
    const Mask& organs;  // see isInsideFascia(): the surface passes outside them
};

// True for lungs, heart, liver (with its lesions), spleen, kidneys, gallbladder, bile ducts and vessels.
// False for pancreas, stomach and bowel: a program often misses their borders. False for diaphragm and fat: a
// CT rarely separates them from the wall.
bool isInsideFascia(const patient::Label&);

// The inner wall in polar coordinates about a vertical axis. Layout: radius_m[z * angles + phi].
struct WallSurface {
    Vec3 axis_m{0.0};  // x and y only
    double z_begin_m = 0.0, z_step_m = 0.004;
    int angles = 144, levels = 0;
    std::vector<double> radius_m;

    // Index of a cell. Levels beyond the ends are clamped; angles up to one turn away are wrapped.
    std::size_t cell(int z, int a) const {
        return std::size_t(std::clamp(z, 0, levels - 1) * angles + (a + angles) % angles);
    }
    std::size_t nearestCell(const Vec3& at_m) const;
    double radiusAt(double phi, double z_m) const;  // bilinear, periodic in phi
};

// The allowed range of the radius in each cell of a surface: inside every bone and outside every organ. Where
// an organ touches a bone, `low_m` may be above `high_m`.
struct RadiusBounds {
    std::vector<double> low_m, high_m;
};
inline constexpr double kFarOff_m = 0.4;  // high_m of a cell without bone
inline constexpr double kMaxCells = 4.0;  // usual reach of a voxel, in cells to each side
// `nearest_m`: low_m of a cell without an organ. A voxel counts in its own cell and in at most `max_cells`
// cells to each side.
RadiusBounds computeRadiusBounds(const FasciaInput&, const WallSurface&, double nearest_m, double max_cells);

// The bones that limit the surface. Drops pieces that are not part of the wall: at most of their voxels, an
// organ lies more than 2 cm farther from the axis. A stent or a calcification, for instance.
Mask wallBones(const FasciaInput&);

// True if a bone limits the radius of a cell at most 24 mm above or below the given cell and at most 3 cells
// to either side.
bool boneNear(const RadiusBounds&, const WallSurface&, int level, int angle);

// Fits the inner wall of chest and abdomen. At the ribs and other bones, the surface lies just inside the
// bone. Below the ribs, it lies on the inner face of the abdominal muscles. Between these places it is
// smooth. The surface stays outside the organs and inside the bones. Where an organ touches a bone, only the
// bone's limit is kept. Bones that wallBones() drops are
// ignored.
WallSurface fitWall(const FasciaInput&);

// Returns the volume enclosed by the surface, without the skin: in a sunken chest the surface may reach the
// skin, and a needle that starts inside the fascia would miss it. Organs are included even where they extend
// beyond the surface or into the skin. A bone is included only if the volume encloses it completely. The
// result is a single connected component without holes.
Mask insideWall(const WallSurface&, const FasciaInput&);

// Returns the boundary of `inside` as a layer that is one voxel thick. No path over face neighbours passes
// through the layer (6-separating). Each pair of face neighbours across the boundary contributes one voxel:
// the outer one if `free` marks it as overwritable, otherwise the inner one.
Mask rasteriseBoundary(const Mask& inside, const Mask& free);

}  // namespace stylet::modeller
