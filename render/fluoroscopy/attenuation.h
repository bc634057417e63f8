// The patient as X-rays see him: attenuation relative to water, 1 + HU / 1000 (model, section 8), in voxels
// no finer than a detector can tell apart, and where there is none.
#pragma once

#include <cstdint>
#include <vector>

#include "patient/patient.h"

namespace stylet::render {

inline constexpr double kWaterPerM = 19.3;  // at about 70 keV
// Air, the room's and the bowel's, is taken for nothing.
inline constexpr double kAirHu = -970.0;

constexpr double relativeAttenuation(double hu) {
    return hu < kAirHu ? 0.0 : 1.0 + hu / 1000.0;
}

struct AttenuationVolume {
    patient::Grid grid;               // the CT's own box
    std::vector<std::uint16_t> half;  // half floats: water is exactly 1
};

// Voxels of about `voxel_m`, or the CT's where those are larger: each the mean of what it covers, so that
// nothing is lost or gained. Several threads.
AttenuationVolume attenuationOf(const patient::CtVolume&, double voxel_m, int threads);

// Cells of about `cell_m`, 1 where anything attenuates within `margin_m` of the cell.
struct CellGrid {
    patient::Grid grid;
    std::vector<std::uint8_t> occupied;
};
CellGrid cellsOf(const AttenuationVolume&, double cell_m, double margin_m);

// A voxel as the sum of those of another grid that lie in it, the first and the last in part.
struct Cover {
    int first = 0;
    std::vector<float> weights;  // shares of the voxel
};
// Of the voxels [low, high) of `to` along an axis, by those of `from`.
std::vector<Cover> coversOf(const patient::Grid& from, const patient::Grid& to, int axis, int low, int high);

}  // namespace stylet::render
