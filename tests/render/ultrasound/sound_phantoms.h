// Blocks of known tissue in front of a probe, and scans of them by each implementation.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/render.h"
#include "render/volume/deformed_patient.h"

namespace stylet::test {

// The shipped table, in which each tissue is also a label with its name.
render::AcousticTable soundTable();
// The shipped table without scatter and attenuation: tissue borders only reflect.
render::AcousticTable mirrorTable();

// A block with x and y within +-half_m and z from -5 mm to depth_m, with air before z = 0. `tissueAt` names
// the tissue at a voxel's centre. Fills the label table of soundTable().
patient::Package soundBlock(const Vec3& half_m, double depth_m, double spacing_m,
                            const std::function<std::string(const Vec3&)>& tissueAt);
// Layers along +z from z = 0. The last one extends to the block's end.
patient::Package soundLayers(const std::vector<std::pair<std::string, double>>& layers_m, double depth_m,
                             double spacing_m);

enum class ScanMethod { reference, serial, prefix_sums };
std::string scanMethodName(ScanMethod);

// Line by line, amplitude before compression.
struct Scan {
    int lines = 0, bins = 0;
    double bin_m = 0.0;
    std::vector<double> envelope;
    double at(int line, int bin) const {
        return envelope[std::size_t(line) * std::size_t(bins) + std::size_t(bin)];
    }
    // Root mean square over a range of lines (shares of the width) and of drawn depths.
    double rms(double from_share, double to_share, double from_m, double to_m) const;
};

Scan scan(ScanMethod by, const patient::Package&, const render::AcousticTable&,
          const render::UltrasoundInput&, render::UltrasoundSettings, const render::Transducer&);

// A probe whose face is at z, centred on the z axis, with +z into the block.
render::UltrasoundInput probeAt(double z_m);

// A linear probe for closed forms: 40 mm of lines, 60 mm depth, 3.5 MHz.
render::Transducer flatProbe();

}  // namespace stylet::test
