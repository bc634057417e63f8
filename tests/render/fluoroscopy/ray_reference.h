// Naive double-precision X-rays, to hold the GPU's to: the geometry written out, voxels exactly or finely
// sampled, the motion asked for at every sample. Shares only data with render/fluoroscopy.
#pragma once

#include <functional>
#include <vector>

#include "patient/contrast/contrast.h"
#include "render/fluoroscopy/fluoroscopy.h"

namespace stylet::test {

struct XrayLine {
    Vec3 source_m{0.0}, pixel_m{0.0};
};
// Of a picture of `pixels` a side, without anybody's rotation classes.
XrayLine xrayLine(const render::FluoroscopyInput&, int column, int row, int pixels, double detector_m);

// Along a line through the CT as it is, voxel by voxel: Siddon, "Fast calculation of the exact radiological
// path for a three-dimensional CT array", Med. Phys. 12, 1985.
double exactPath(const CtVolume&, const XrayLine&);

// Through the patient as breath and tool have him, with contrast, the nearest voxel at every `step_m`.
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
// Of two pictures of line integrals as the screen's range of them has it, dB.
double pathPsnr(const std::vector<double>& reference, const std::vector<double>&);

// Attenuation of `hu(p)` in a box around the origin, each voxel the mean of 4^3 points.
patient::Package makeXrayPhantom(const Vec3& half_m, double spacing_m,
                                 const std::function<double(const Vec3&)>& hu);

// The same patient's CT in voxels of half the size, linear between the old ones.
patient::Package finerCt(const patient::Package&);

}  // namespace stylet::test
