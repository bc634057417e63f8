// A thin curved tube for pictures: a guide wire, a dilator or a drain.
#pragma once

#include <vector>

#include "base/geometry.h"

namespace stylet {

struct CurvedTube {
    std::vector<Vec3> points_m;  // at least two; patient frame, deformed
    double radius_m = 0.0005, bore_m = 0.0;
    double attenuation_per_m = 0.0;  // linear attenuation of the material at 70 keV
    Vec3 colour{0.7};                // linear
};

}  // namespace stylet
