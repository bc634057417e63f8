// Naive X-ray projection in double precision, as a reference for the GPU's. Computes the geometry with plain
// trigonometry, reads exact or finely sampled voxels, and evaluates the motion at every sample. Shares only
// data with render/fluoroscopy.
#pragma once

#include <functional>
#include <vector>

#include "patient/contrast/contrast.h"
#include "render/fluoroscopy/fluoroscopy.h"

namespace stylet::test {

struct XrayLine {
    Vec3 source_m{0.0}, pixel_m{0.0};
};
// Line of one pixel in a square picture with `pixels` per side, computed without rotation classes.
XrayLine xrayLine(const render::FluoroscopyInput&, int column, int row, int pixels, double detector_m);

// Line integral through the CT at rest, voxel by voxel. Siddon, "Fast calculation of the exact radiological
// path for a three-dimensional CT array", Med. Phys. 12, 1985.
double exactPath(const CtVolume&, const XrayLine&);

// A patient deformed by breath and tool, with contrast medium. finePath() reads the nearest voxel every
// `step_m`.
struct XrayPatient {
    const patient::Package* package = nullptr;
    patient::Surrogate breath;
    const patient::DisplacementTable* tool = nullptr;
    const patient::ContrastTable* contrast = nullptr;
    double beyond_ends_m = 0.0, step_m = 0.0001;
};
double finePath(const XrayPatient&, const XrayLine&);

// Zero-mean normalised cross-correlation.
double zncc(const std::vector<double>&, const std::vector<double>&);
// Peak signal to noise ratio of two pictures of line integrals, over the screen's range, dB.
double pathPsnr(const std::vector<double>& reference, const std::vector<double>&);

// A phantom with the CT values `hu(p)` in a box around the origin. Each voxel is the mean of 4^3 points.
patient::Package makeXrayPhantom(const Vec3& half_m, double spacing_m,
                                 const std::function<double(const Vec3&)>& hu);

// The same patient with CT voxels of half the size, interpolated linearly.
patient::Package finerCt(const patient::Package&);

}  // namespace stylet::test
