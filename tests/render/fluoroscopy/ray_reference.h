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

// Line integral through a shape's shaft, without its round ends.
double shaftPath(const render::XrayShape&, const XrayLine&);

// Straight steel shafts in the middle of the picture, drawn at many sub-pixel positions.
struct ShaftErrors {
    double area = 0.0;     // largest relative error of the attenuation, summed across the shaft
    double flicker = 0.0;  // largest share by which the densest pixel depends on the sub-pixel position
};
// `draw`: the line integrals of shapes alone in a picture of `pixels` per side. `turned_rad`: on the screen,
// from the vertical. `tilted_rad`: out of the plane of the isocentre, toward the beam.
ShaftErrors shaftErrors(const std::function<std::vector<double>(const render::XrayShape&)>& draw,
                        const render::FluoroscopySettings&, double radius_m, double turned_rad,
                        double tilted_rad, const Vec3& isocentre_m = Vec3(0.0));

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
