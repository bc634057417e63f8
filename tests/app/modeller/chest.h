// A synthetic breathing chest with any number of phases: a lung above a dome, surrounded by ribs.
#pragma once

#include <cmath>
#include <vector>

#include "app/modeller/motion/phases.h"

namespace stylet::test {

struct ChestSettings {
    double spacing_m = 0.0025;
    double travel_m = 0.010;  // travel of the dome and everything inside the ribs, toward the feet
    int phases = 8;
};

inline double breathingState(int phase, int phases) {
    const double s = std::sin(3.14159265358979323846 * phase / phases);
    return s * s;
}

// Ribs: rings with a radius of 75 mm about the z axis, every 20 mm. Lung: 68 mm in radius, down to a dome
// 20 mm high. Everything inside the ribs moves as one body.
inline modeller::Phase chestPhase(const ChestSettings& s, int phase) {
    modeller::Phase out;
    out.name = "phase" + std::to_string(phase);
    Grid& g = out.hu.grid;
    g.spacing_m = Vec3(s.spacing_m);
    g.dims = Index3(int(0.18 / s.spacing_m), int(0.18 / s.spacing_m), int(0.12 / s.spacing_m));
    g.origin_m = -0.5 * s.spacing_m * Vec3(g.dims - 1);
    out.hu = modeller::FloatVolume(g);
    const double down_m = s.travel_m * breathingState(phase, s.phases);
    forEachVoxel(g, [&](const Index3& i) {
        const Vec3 p = g.centre(i);
        const double r_m = std::hypot(p.x, p.y), tissue_z_m = p.z + down_m;
        const double dome_z_m = 0.010 - 4.0 * r_m * r_m;
        const double texture =
            std::sin(260.0 * p.x) * std::sin(240.0 * p.y + 1.0) * std::sin(250.0 * tissue_z_m);
        const double edge = std::clamp((tissue_z_m - dome_z_m) / s.spacing_m + 0.5, 0.0, 1.0);
        double hu = (1.0 - edge) * (60.0 + 30.0 * texture) +
                    edge * (-800.0 + 120.0 * texture + 4000.0 * down_m * -1.0);
        if (r_m > 0.068) hu = 20.0 + 20.0 * std::sin(300.0 * p.z) * std::sin(200.0 * p.x);
        if (std::fabs(r_m - 0.075) < 0.004 && std::fabs(std::remainder(p.z, 0.020)) < 0.005) hu = 700.0;
        out.hu[i] = float(hu);
    });
    return out;
}

inline std::vector<modeller::Phase> chestPhases(const ChestSettings& s = {}) {
    std::vector<modeller::Phase> phases;
    for (int p = 0; p < s.phases; ++p)
        phases.push_back(chestPhase(s, p));
    return phases;
}

}  // namespace stylet::test
