// X-ray attenuation of the patient relative to water, 1 + HU / 1000 (model, section 8). The voxels are no
// finer than a detector resolves. A coarser grid marks the cells that contain any attenuation.
#pragma once

#include <cstdint>
#include <vector>

#include "patient/patient.h"

namespace stylet::render {

inline constexpr double kWaterPerM = 19.3;  // at about 70 keV
// Everything below this value is air, of the room or the bowel, and counts as no attenuation.
inline constexpr double kAirHu = -970.0;

constexpr double relativeAttenuation(double hu) {
    return hu < kAirHu ? 0.0 : 1.0 + hu / 1000.0;
}

struct AttenuationVolume {
    Grid grid;                        // the CT's own box
    std::vector<std::uint16_t> half;  // half floats: water is exactly 1
};

// Resamples to voxels of about `voxel_m`, or to the CT's where those are larger. Each voxel is the mean of
// the CT inside it, so the total is preserved. Uses `threads` threads.
AttenuationVolume computeAttenuation(const CtVolume&, double voxel_m, int threads);

// Cells of about `cell_m`: 1 where anything attenuates within `margin_m` of the cell.
struct CellGrid {
    Grid grid;
    std::vector<std::uint8_t> occupied;
};
CellGrid makeCellGrid(const AttenuationVolume&, double cell_m, double margin_m);

// Along one axis: the weights of the fine voxels inside a coarse voxel. The first and the last fine voxel may
// lie in it only partly.
struct ResampleWeights {
    int first = 0;
    std::vector<float> weights;  // fractions of the coarse voxel
};
// Computes the weights of the fine voxels (`from`) for coarse voxels [low, high) of `to` along an axis.
std::vector<ResampleWeights> computeResampleWeights(const Grid& from, const Grid& to, int axis, int low,
                                                    int high);

}  // namespace stylet::render
