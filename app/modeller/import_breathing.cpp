#include "app/modeller/import_breathing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stylet::modeller {

using patient::BreathingModel;
using patient::CavityKnot;
using patient::Grid;
using patient::Vec3;

namespace {

constexpr double kKnotStep_m = 0.010;
// What a voxel on the wrong side costs. A rib that moves with the liver would close its own gap: worst. A rim
// of liver that rests at the ribs does little harm, a spine that moves is hardly seen.
constexpr double kLiverOut = 1.5, kOrganOut = 0.5, kRibIn = 15.0, kSpineIn = 0.1;

struct Sample {
    double x_m, y_m, cost_outside, cost_inside;
};

// Voxels near one level, thinned to every third.
std::vector<Sample> samplesAt(double z_m, const WallSurface& wall, const Mask& liver, const Mask& moving,
                              const Mask& bones) {
    const Grid& g = liver.grid;
    std::vector<Sample> out;
    const int z = std::clamp(g.nearest({0.0, 0.0, z_m}).z, 0, g.dims.z - 1);
    for (int y = 0; y < g.dims.y; y += 3)
        for (int x = 0; x < g.dims.x; x += 3) {
            const patient::Index3 i{x, y, z};
            const Vec3 p = g.centre(i);
            if (liver[i])
                out.push_back({p.x, p.y, kLiverOut, 0.0});
            else if (moving[i])
                out.push_back({p.x, p.y, kOrganOut, 0.0});
            else if (bones[i]) {
                const bool spine = std::fabs(p.x - wall.axis_m.x) < 0.045 && p.y < wall.axis_m.y;
                out.push_back({p.x, p.y, 0.0, spine ? kSpineIn : kRibIn});
            }
        }
    return out;
}

double rho(const CavityKnot& k, double x_m, double y_m) {
    return std::hypot((x_m - k.x_m) / k.rx_m, (y_m - k.y_m) / k.ry_m);
}

double costOf(const CavityKnot& k, const CavityKnot& start, const std::vector<Sample>& samples) {
    double cost = 0.0;
    for (const Sample& s : samples)
        cost += rho(k, s.x_m, s.y_m) < 1.0 ? s.cost_inside : s.cost_outside;
    // Where nothing pulls, the wall's own extent holds.
    const double shift = std::hypot(k.x_m - start.x_m, k.y_m - start.y_m) +
                         std::hypot(k.rx_m - start.rx_m, k.ry_m - start.ry_m);
    return cost + 1500.0 * shift;
}

CavityKnot fromWall(const WallSurface& wall, double z_m) {
    double x_low = 1.0, x_high = -1.0, y_low = 1.0, y_high = -1.0;
    for (int a = 0; a < wall.angles; ++a) {
        const double phi = a * 2.0 * std::numbers::pi / wall.angles, r = wall.radiusAt(phi, z_m);
        x_low = std::min(x_low, r * std::cos(phi)), x_high = std::max(x_high, r * std::cos(phi));
        y_low = std::min(y_low, r * std::sin(phi)), y_high = std::max(y_high, r * std::sin(phi));
    }
    return {z_m, wall.axis_m.x + 0.5 * (x_low + x_high), wall.axis_m.y + 0.5 * (y_low + y_high),
            0.5 * (x_high - x_low), 0.5 * (y_high - y_low)};
}

// Coordinate search, from 8 mm steps down to 1 mm.
CavityKnot fitKnot(const CavityKnot& start, const std::vector<Sample>& samples) {
    CavityKnot best = start;
    double best_cost = costOf(best, start, samples);
    for (double step = 0.008; step > 0.0008; step *= 0.5)
        for (bool better = true; better;) {
            better = false;
            for (double CavityKnot::* what :
                 {&CavityKnot::x_m, &CavityKnot::y_m, &CavityKnot::rx_m, &CavityKnot::ry_m})
                for (double sign : {-1.0, 1.0}) {
                    CavityKnot next = best;
                    next.*what += sign * step;
                    if (next.rx_m < 0.03 || next.ry_m < 0.03) continue;
                    const double cost = costOf(next, start, samples);
                    if (cost < best_cost) best = next, best_cost = cost, better = true;
                }
        }
    return best;
}

void smoothKnots(std::vector<CavityKnot>& knots) {
    const std::vector<CavityKnot> old = knots;
    for (std::size_t i = 1; i + 1 < knots.size(); ++i)
        for (double CavityKnot::* what :
             {&CavityKnot::x_m, &CavityKnot::y_m, &CavityKnot::rx_m, &CavityKnot::ry_m})
            knots[i].*what = 0.25 * old[i - 1].*what + 0.5 * old[i].*what + 0.25 * old[i + 1].*what;
}

}  // namespace

BreathingModel fitBreathing(const WallSurface& wall, const Mask& liver, const Mask& moving, const Mask& bones,
                            double travel_m) {
    const Grid& g = liver.grid;
    int liver_low = g.dims.z, liver_high = 0;
    for (std::size_t i = 0; i < liver.voxels.size(); ++i)
        if (liver.voxels[i]) {
            const int z = int(i / (std::size_t(g.dims.x) * std::size_t(g.dims.y)));
            liver_low = std::min(liver_low, z), liver_high = std::max(liver_high, z);
        }
    BreathingModel m;
    m.a1_m = -travel_m;
    m.z_full_low_m = g.centre({0, 0, liver_low}).z - 0.003;
    m.z_full_high_m = g.centre({0, 0, liver_high}).z + travel_m + 0.010;
    // Rest is reached within the scan where that leaves the field monotone, so that no air is drawn in from
    // below.
    m.z_low_m = std::min(m.z_full_low_m - 0.035, std::max(m.z_full_low_m - 0.060, g.origin_m.z + 0.002));
    m.z_high_m = m.z_full_high_m + 0.060;

    const double top_m = g.centre(g.dims - 1).z;
    for (double z = m.z_low_m - kKnotStep_m; z < m.z_high_m + 2.0 * kKnotStep_m; z += kKnotStep_m) {
        const double seen_z = std::clamp(z, g.origin_m.z, top_m);
        CavityKnot k = fitKnot(fromWall(wall, seen_z), samplesAt(seen_z, wall, liver, moving, bones));
        k.z_m = z;
        m.cavity.push_back(k);
    }
    for (int pass = 0; pass < 2; ++pass)
        smoothKnots(m.cavity);
    return m;
}

}  // namespace stylet::modeller
