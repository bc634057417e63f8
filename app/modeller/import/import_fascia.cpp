#include "app/modeller/import/import_fascia.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stylet::modeller {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kInsideBone_m = 0.0015, kOutsideOrgan_m = 0.0010;
// Weight, in the fit, of a radius observed along a ray through the abdominal wall. A radius observed at a
// bone has weight 1.
constexpr double kBellyWeight = 0.3;

// Per cell of the surface: the allowed range of its radius, and the observed radius with its weight.
struct Cells {
    std::vector<double> low_m, high_m, seen_m, weight;
};

// Calls f(cell, radius) for each cell covered by a voxel of the mask.
template <typename F>
void forEachCovered(const Mask& mask, const WallSurface& s, F&& f) {
    const Grid& g = mask.grid;
    const double half_m = 0.5 * std::max(g.spacing_m.x, g.spacing_m.y);
    for (int z = 0; z < g.dims.z; ++z) {
        const int level =
            std::clamp(int(std::lround((g.centre({0, 0, z}).z - s.z_begin_m) / s.z_step_m)), 0, s.levels - 1);
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                if (!mask[{x, y, z}]) continue;
                const Vec3 d = g.centre({x, y, z}) - s.axis_m;
                const double r = std::hypot(d.x, d.y), phi = std::atan2(d.y, d.x) / kTurn * s.angles;
                const double reach =
                    std::min(s.angles / 4.0, half_m / std::max(r, half_m) / kTurn * s.angles);
                for (int k = int(std::lround(phi - reach)); k <= int(std::lround(phi + reach)); ++k)
                    f(std::size_t(level * s.angles + (k + s.angles) % s.angles), r);
            }
    }
}

// Follows a ray from the skin inward: fat, then muscle. Returns the radius of the muscle's inner face, or 0
// if it is not visible.
double innerFaceOfBellyWall(const FasciaInput& in, const FloatVolume& smooth_ct, const WallSurface& s,
                            double phi, double z_m) {
    constexpr double kStep_m = 0.001, kMuscle_hu = 5.0, kFat_hu = -40.0;
    constexpr double kThin_m = 0.006, kUsual_m = 0.012, kThick_m = 0.020;
    const Grid& g = in.ct.grid;
    double outer_m = 0.0;
    int run = 0;
    for (double r = 0.35; r > 0.02; r -= kStep_m) {
        const Vec3 p{s.axis_m.x + r * std::cos(phi), s.axis_m.y + r * std::sin(phi), z_m};
        const Index3 i = g.nearest(p);
        if (!g.contains(i) || !in.body[i]) continue;
        const double hu = smooth_ct[i];
        if (outer_m == 0.0) {
            run = hu > kMuscle_hu ? run + 1 : 0;
            if (run == 4) outer_m = r + 3.0 * kStep_m;
            if (run == 4 && in.bones[i]) return 0.0;
        } else if (hu < kFat_hu || in.organs[i] || outer_m - r > kThick_m) {
            const double thick_m = outer_m - r;
            return outer_m - (thick_m > kThick_m ? kUsual_m : std::max(thick_m, kThin_m));
        }
    }
    return 0.0;
}

// Returns the same inputs with a body mask that lacks the outermost 6 mm. The skin is as dense as muscle and
// would be mistaken for it. `inner_body` receives the new mask and must outlive the result.
FasciaInput withoutRim(const FasciaInput& in, Mask& inner_body) {
    Mask air = in.body;
    for (std::uint8_t& v : air.voxels)
        v = v ? 0 : 1;
    const FloatVolume depth = distanceTo(air);
    inner_body = in.body;
    for (std::size_t i = 0; i < depth.voxels.size(); ++i)
        if (depth.voxels[i] < 0.006f) inner_body.voxels[i] = 0;
    return {in.ct, inner_body, in.bones, in.organs};
}

// Drops rays through the abdominal wall that disagree with their neighbours. Bowel, folds and the navel
// mislead single rays.
void dropOutliers(Cells& c, const WallSurface& s) {
    constexpr double kAgree_m = 0.004;
    constexpr int kReach_z = 5, kReach_phi = 8;
    std::vector<double> near, weight = c.weight;
    for (int z = 0; z < s.levels; ++z)
        for (int a = 0; a < s.angles; ++a) {
            const std::size_t cell = std::size_t(z * s.angles + a);
            if (c.weight[cell] != kBellyWeight) continue;
            near.clear();
            for (int dz = -kReach_z; dz <= kReach_z; ++dz)
                for (int da = -kReach_phi; da <= kReach_phi; ++da) {
                    const int zz = std::clamp(z + dz, 0, s.levels - 1), aa = (a + da + s.angles) % s.angles;
                    const std::size_t other = std::size_t(zz * s.angles + aa);
                    if (c.weight[other] > 0.0) near.push_back(c.seen_m[other]);
                }
            // The reference is the upper quartile of the neighbours' radii, not their median. Wrong rays end
            // too deep, that is, at too small a radius.
            const auto upper = near.begin() + std::ptrdiff_t(near.size() * 3 / 4);
            std::nth_element(near.begin(), upper, near.end());
            if (std::fabs(c.seen_m[cell] - *upper) > kAgree_m) weight[cell] = 0.0;
        }
    c.weight = weight;
}

Cells observe(const FasciaInput& in, const WallSurface& s) {
    const std::size_t n = std::size_t(s.angles * s.levels);
    Cells c{std::vector<double>(n, 0.02), std::vector<double>(n, 0.4), std::vector<double>(n, 0.0),
            std::vector<double>(n, 0.0)};
    forEachCovered(in.bones, s, [&](std::size_t cell, double r) {
        c.high_m[cell] = std::min(c.high_m[cell], r - kInsideBone_m);
    });
    forEachCovered(in.organs, s, [&](std::size_t cell, double r) {
        c.low_m[cell] = std::max(c.low_m[cell], r + kOutsideOrgan_m);
    });
    for (std::size_t i = 0; i < n; ++i)
        if (c.high_m[i] < 0.4) c.seen_m[i] = c.high_m[i], c.weight[i] = 1.0;

    Mask inner_body;
    const FasciaInput inner = withoutRim(in, inner_body);
    FloatVolume ct(in.ct.grid);
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        ct.voxels[i] = float(in.ct.voxels[i]);
    const FloatVolume smooth_ct = boxMean(ct, 1);
    const std::vector<double> bone_weight = c.weight;
    const int near_z = int(0.024 / s.z_step_m), near_phi = 3;
    for (int z = 0; z < s.levels; ++z)
        for (int a = 0; a < s.angles; ++a) {
            const std::size_t cell = std::size_t(z * s.angles + a);
            bool bone_near = false;
            for (int dz = -near_z; dz <= near_z && !bone_near; ++dz)
                for (int da = -near_phi; da <= near_phi && !bone_near; ++da) {
                    const int zz = std::clamp(z + dz, 0, s.levels - 1), aa = (a + da + s.angles) % s.angles;
                    bone_near = bone_weight[std::size_t(zz * s.angles + aa)] > 0.0;
                }
            const double phi = a * kTurn / s.angles;
            // At the back, the thick muscles hide the inner face of the wall.
            const bool back = std::sin(phi) < -0.5;
            if (bone_near || back) continue;
            const double r = innerFaceOfBellyWall(inner, smooth_ct, s, phi, s.z_begin_m + z * s.z_step_m);
            if (r > 0.0) c.seen_m[cell] = r, c.weight[cell] = kBellyWeight;
        }
    dropOutliers(c, s);
    return c;
}

double fitted(double r, const Cells& c, std::size_t cell) {
    // Where an organ touches a bone, the bone wins: the organ's outermost voxel becomes fascia.
    return std::clamp(r, std::min(c.low_m[cell], c.high_m[cell]), c.high_m[cell]);
}

// Minimises  sum weight (r - seen)^2 + |grad r|^2  within each cell's allowed range, by over-relaxation.
void relax(WallSurface& s, const Cells& c) {
    double mean = 0.0, count = 0.0;
    for (std::size_t i = 0; i < c.weight.size(); ++i)
        if (c.weight[i] > 0.0) mean += c.seen_m[i], count += 1.0;
    mean = count > 0.0 ? mean / count : 0.1;
    for (std::size_t i = 0; i < c.weight.size(); ++i)
        s.radius_m[i] = fitted(c.weight[i] > 0.0 ? c.seen_m[i] : mean, c, i);
    constexpr double kData = 4.0, kOver = 1.6;
    for (int sweep = 0; sweep < 500; ++sweep)
        for (int z = 0; z < s.levels; ++z)
            for (int a = 0; a < s.angles; ++a) {
                const auto at = [&](int zz, int aa) {
                    return s.radius_m[std::size_t(std::clamp(zz, 0, s.levels - 1) * s.angles +
                                                  (aa + s.angles) % s.angles)];
                };
                const std::size_t cell = std::size_t(z * s.angles + a);
                const double w = kData * c.weight[cell];
                const double sum = at(z - 1, a) + at(z + 1, a) + at(z, a - 1) + at(z, a + 1);
                const double best = (w * c.seen_m[cell] + sum) / (w + 4.0);
                s.radius_m[cell] = fitted(s.radius_m[cell] + kOver * (best - s.radius_m[cell]), c, cell);
            }
}

// The middle of the body, shifted to the front so that spine and great vessels are behind the axis.
Vec3 axisOf(const Mask& body) {
    int x_low = body.grid.dims.x, x_high = 0, y_low = body.grid.dims.y, y_high = 0;
    for (int z = 0; z < body.grid.dims.z; ++z)
        for (int y = 0; y < body.grid.dims.y; ++y)
            for (int x = 0; x < body.grid.dims.x; ++x)
                if (body[{x, y, z}]) {
                    x_low = std::min(x_low, x), x_high = std::max(x_high, x);
                    y_low = std::min(y_low, y), y_high = std::max(y_high, y);
                }
    const Vec3 low = body.grid.centre({x_low, y_low, 0}), high = body.grid.centre({x_high, y_high, 0});
    return {0.5 * (low.x + high.x), 0.5 * (low.y + high.y) + 0.12 * (high.y - low.y), 0.0};
}

}  // namespace

double WallSurface::radiusAt(double phi, double z_m) const {
    double u = phi / kTurn * angles;
    u -= std::floor(u / angles) * angles;
    const double v = std::clamp((z_m - z_begin_m) / z_step_m, 0.0, double(levels - 1));
    const int a = int(u), z = std::min(int(v), levels - 2);
    const double fu = u - a, fv = v - z;
    const auto at = [&](int zz, int aa) { return radius_m[std::size_t(zz * angles + aa % angles)]; };
    return (1.0 - fv) * ((1.0 - fu) * at(z, a) + fu * at(z, a + 1)) +
           fv * ((1.0 - fu) * at(z + 1, a) + fu * at(z + 1, a + 1));
}

WallSurface fitWall(const FasciaInput& in) {
    const Grid& g = in.body.grid;
    WallSurface s;
    s.axis_m = axisOf(in.body);
    s.z_begin_m = g.origin_m.z;
    s.levels = std::max(2, int(std::ceil((g.dims.z - 1) * g.spacing_m.z / s.z_step_m)) + 1);
    s.radius_m.assign(std::size_t(s.angles * s.levels), 0.1);
    relax(s, observe(in, s));
    return s;
}

Mask insideWall(const WallSurface& s, const FasciaInput& in) {
    const Grid& g = in.body.grid;
    Mask inside(g);
    forEachSlab(g.dims.z, [&](int z) {
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                const Vec3 p = g.centre(i), d = p - s.axis_m;
                const bool near = std::hypot(d.x, d.y) < s.radiusAt(std::atan2(d.y, d.x), p.z);
                inside[i] = in.body[i] && !in.bones[i] && (near || in.organs[i]);
            }
    });
    keepLargest(inside);
    // Add every bone and every cavity that is enclosed by `inside`: flood the complement from the left and
    // right faces of the image. All voxels that the flood does not reach are inside.
    Mask outside = inside, seeds(g);
    for (std::uint8_t& v : outside.voxels)
        v = v ? 0 : 1;
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            seeds[{0, y, z}] = seeds[{g.dims.x - 1, y, z}] = 1;
    const Mask reached = floodFrom(seeds, outside);
    for (std::size_t i = 0; i < inside.voxels.size(); ++i)
        inside.voxels[i] = reached.voxels[i] ? 0 : 1;
    return inside;
}

Mask rasteriseBoundary(const Mask& inside, const Mask& free) {
    const Grid& g = inside.grid;
    Mask surface(g);
    const Index3 steps[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x)
                for (const Index3& step : steps) {
                    const Index3 a{x, y, z}, b = a + step;
                    if (!g.contains(b) || inside[a] == inside[b]) continue;
                    const Index3 outer = inside[a] ? b : a, inner = inside[a] ? a : b;
                    surface[free[outer] ? outer : inner] = 1;
                }
    return surface;
}

}  // namespace stylet::modeller
