// A naive scan in double precision: every bin visits every change of tissue. Shares only data with
// render/ultrasound: the packed voxels, the plan's numbers, the acoustic table.
#pragma once

#include <complex>
#include <functional>
#include <vector>

#include "render/ultrasound/acoustic_volume.h"
#include "render/ultrasound/contact.h"
#include "render/ultrasound/scan_uniforms.h"

namespace stylet::test {

struct EncodedPatient {
    Grid grid;
    std::vector<std::uint32_t> voxels;
};
EncodedPatient encode(const patient::Patient&, const render::AcousticTable&);

struct ReferenceScan {
    int lines = 0, bins = 0;
    double bin_m = 0.0;
    std::vector<double> envelope;  // line by line
};

// Share of injected fluid in soft tissue at a place of the reference patient.
double fluidShare(const std::vector<render::UltrasoundInput::Depot>&, const Vec3&);

using Undeform = std::function<Vec3(const Vec3&)>;  // patient frame to reference

// Scans without electronic noise, with every line in full contact.
ReferenceScan referenceScan(const EncodedPatient&, const render::AcousticTable&, const Undeform&,
                            const render::UltrasoundInput&, const render::UltrasoundSettings&,
                            const render::Transducer&);

// The picture as drawn: values 0 to 1, rows from the top, black outside the scan, without marks.
std::vector<double> referencePicture(const ReferenceScan&, const render::UltrasoundSettings&,
                                     const render::Transducer&);

}  // namespace stylet::test
