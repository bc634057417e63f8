// CT values of another scan than the reference patient's: contrast phase, tube voltage, fat in the liver.
#pragma once

#include "patient/synth/ct.h"

namespace stylet::patient::synth {

enum class Phase { native, arterial, portal, late };

struct Scanner {
    Phase phase = Phase::portal;
    double iodine = 1.0;        // enhancement relative to 120 kV
    double bone = 1.0;          // HU of bone relative to 120 kV
    double fat_hu = 0.0;        // shift of fat
    double liver_fat_hu = 0.0;  // shift of a liver with steatosis, negative
    double noise = 1.0;         // factor on the noise: the dose
    double kernel_noise = 1.0;  // factor on the noise: the kernel
    int blur_passes = 1;
    double slice_m = 0.0;  // thickness of the slices; thinner than a voxel: the voxels are the slices
};

CtSettings ctSettings(const Scanner&);

// Replaces the volume by slices of this thickness, interpolated to the volume's own voxels, as a workstation
// shows them. Averages the noise too.
void thickenSlices(CtVolume&, double thickness_m);

// Adds dark and bright streaks that start at values of metal, in the slices that contain them.
void addStreaks(CtVolume&);

}  // namespace stylet::patient::synth
