#include "app/modeller/wall/body_wall.h"

#include <algorithm>
#include <cmath>

#include "app/modeller/image/mask_runs.h"

namespace stylet::modeller {

namespace {

constexpr double kInsideBone_m = 0.0015, kOutsideOrgan_m = 0.0010;
constexpr double kNearest_m = 0.02;     // smallest radius of the surface
constexpr double kSkinShell_m = 0.002;  // thickness that skinShell() is given
// Weight, in the fit, of a radius observed along a ray through the abdominal wall. A radius observed at a
// bone has weight 1.
constexpr double kBellyWeight = 0.3;

// Per cell of the surface: the allowed range of its radius, and the observed radius with its weight.
struct Cells {
    RadiusBounds allowed;
    std::vector<double> observed_m, weight;
};

// A column of voxels as seen from the upright axis of a surface.
struct Column {
    double angle, distance_m;
};
// The columns of a grid, at the offsets of its first slice.
std::vector<Column> columnsAround(const Vec3& axis_m, const Grid& g) {
    std::vector<Column> columns;
    forEachVoxel(VoxelBox{Index3(0), {g.dims.x - 1, g.dims.y - 1, 0}}, [&](const Index3& i) {
        const Vec3 d = g.centre(i) - axis_m;
        columns.push_back({std::atan2(d.y, d.x), std::hypot(d.x, d.y)});
    });
    return columns;
}

// Calls visit(cell, radius) for each cell that a voxel of the mask covers.
template <typename Visit>
void forEachCoveredCell(const Mask& mask, const WallSurface& s, double max_cells, const Visit& visit) {
    const Grid& g = mask.grid;
    const double half_m = 0.5 * std::max(g.spacing_m.x, g.spacing_m.y);
    const std::vector<Column> columns = columnsAround(s.axis_m, g);
    forEachVoxel(g, [&](const Index3& i) {
        if (!mask[i]) return;
        const int level = std::clamp(int(std::lround((g.centre({0, 0, i.z}).z - s.z_begin_m) / s.z_step_m)),
                                     0, s.levels - 1);
        const Column& column = columns[g.offset({i.x, i.y, 0})];
        const double r = column.distance_m, phi = column.angle / kFullTurn * s.angles;
        const double reach = std::min(max_cells, half_m / std::max(r, half_m) / kFullTurn * s.angles);
        for (int k = int(std::lround(phi - reach)); k <= int(std::lround(phi + reach)); ++k)
            visit(s.cell(level, k), r);
    });
}

// Follows a ray from the skin inward: fat, then muscle. Returns the radius of the muscle's inner face, or 0
// if it is not visible.
double findInnerBellyWall(const FasciaInput& in, const FloatVolume& smooth_ct, const WallSurface& s,
                          double phi, double z_m) {
    constexpr double kStep_m = 0.001, kMuscle_hu = 5.0, kFat_hu = -40.0;
    constexpr double kThin_m = 0.006, kUsual_m = 0.012, kThickWall_m = 0.020;
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
        } else if (hu < kFat_hu || in.organs[i] || outer_m - r > kThickWall_m) {
            const double thick_m = outer_m - r;
            return outer_m - (thick_m > kThickWall_m ? kUsual_m : std::max(thick_m, kThin_m));
        }
    }
    return 0.0;
}

// Returns the same inputs with a body mask that lacks the outermost 6 mm. The skin is as dense as muscle and
// would be mistaken for it. `inner_body` receives the new mask and must outlive the result.
FasciaInput erodeBodyRim(const FasciaInput& in, Mask& inner_body) {
    const FloatVolume depth = distanceTo(inverted(in.body));
    inner_body =
        maskWhere(depth.grid, [&](std::size_t i) { return in.body.voxels[i] && depth.voxels[i] >= 0.006f; });
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
            const std::size_t cell = s.cell(z, a);
            if (c.weight[cell] != kBellyWeight) continue;
            near.clear();
            for (int dz = -kReach_z; dz <= kReach_z; ++dz)
                for (int da = -kReach_phi; da <= kReach_phi; ++da)
                    if (const std::size_t other = s.cell(z + dz, a + da); c.weight[other] > 0.0)
                        near.push_back(c.observed_m[other]);
            // The reference is the upper quartile of the neighbours' radii, not their median. Wrong rays end
            // too deep, that is, at too small a radius.
            const auto upper = near.begin() + std::ptrdiff_t(near.size() * 3 / 4);
            std::nth_element(near.begin(), upper, near.end());
            if (std::fabs(c.observed_m[cell] - *upper) > kAgree_m) weight[cell] = 0.0;
        }
    c.weight = weight;
}

Cells observeWall(const FasciaInput& in, const WallSurface& s) {
    const std::size_t n = std::size_t(s.angles * s.levels);
    Cells c{computeRadiusBounds(in, s, kNearest_m, s.angles / 4.0), std::vector<double>(n, 0.0),
            std::vector<double>(n, 0.0)};
    for (std::size_t i = 0; i < n; ++i)
        if (c.allowed.high_m[i] < kFarOff_m) c.observed_m[i] = c.allowed.high_m[i], c.weight[i] = 1.0;

    Mask inner_body;
    const FasciaInput inner = erodeBodyRim(in, inner_body);
    const FloatVolume smooth_ct = boxMean(toFloat(in.ct), 1);
    for (int z = 0; z < s.levels; ++z)
        for (int a = 0; a < s.angles; ++a) {
            const std::size_t cell = s.cell(z, a);
            const double phi = a * kFullTurn / s.angles;
            // At the back, the thick muscles hide the inner face of the wall.
            const bool back = std::sin(phi) < -0.5;
            if (back || boneNear(c.allowed, s, z, a)) continue;
            const double r = findInnerBellyWall(inner, smooth_ct, s, phi, s.z_begin_m + z * s.z_step_m);
            if (r > 0.0) c.observed_m[cell] = r, c.weight[cell] = kBellyWeight;
        }
    dropOutliers(c, s);
    return c;
}

double clampToBounds(double r, const Cells& c, std::size_t cell) {
    // Where an organ touches a bone, the bone wins: the organ's outermost voxel becomes fascia.
    const double high_m = c.allowed.high_m[cell];
    return std::clamp(r, std::min(c.allowed.low_m[cell], high_m), high_m);
}

// Minimises  sum weight (r - observed)^2 + |grad r|^2  within each cell's allowed range, by over-relaxation.
void relax(WallSurface& s, const Cells& c) {
    double mean = 0.0, count = 0.0;
    for (std::size_t i = 0; i < c.weight.size(); ++i)
        if (c.weight[i] > 0.0) mean += c.observed_m[i], count += 1.0;
    mean = count > 0.0 ? mean / count : 0.1;
    for (std::size_t i = 0; i < c.weight.size(); ++i)
        s.radius_m[i] = clampToBounds(c.weight[i] > 0.0 ? c.observed_m[i] : mean, c, i);
    constexpr double kData = 4.0, kOver = 1.6;
    for (int sweep = 0; sweep < 500; ++sweep)
        for (int z = 0; z < s.levels; ++z)
            for (int a = 0; a < s.angles; ++a) {
                const auto at = [&](int zz, int aa) { return s.radius_m[s.cell(zz, aa)]; };
                const std::size_t cell = s.cell(z, a);
                const double w = kData * c.weight[cell];
                const double sum = at(z - 1, a) + at(z + 1, a) + at(z, a - 1) + at(z, a + 1);
                const double best = (w * c.observed_m[cell] + sum) / (w + 4.0);
                s.radius_m[cell] =
                    clampToBounds(s.radius_m[cell] + kOver * (best - s.radius_m[cell]), c, cell);
            }
}

// Returns the axis of the surface: the middle of the body, shifted to the front so that spine and great
// vessels are behind the axis.
Vec3 findAxis(const Mask& body) {
    const VoxelBox box = boundingBox(body);
    const Vec3 low = body.grid.centre(box.low), high = body.grid.centre(box.high);
    return {0.5 * (low.x + high.x), 0.5 * (low.y + high.y) + 0.12 * (high.y - low.y), 0.0};
}

// For each cell, the smallest radius that lies outside every organ; `nearest_m` where the cell has no organ.
std::vector<double> outsideOrgans(const Mask& organs, const WallSurface& s, double nearest_m,
                                  double max_cells) {
    std::vector<double> low_m(std::size_t(s.angles * s.levels), nearest_m);
    forEachCoveredCell(organs, s, max_cells, [&](std::size_t cell, double r) {
        low_m[cell] = std::max(low_m[cell], r + kOutsideOrgan_m);
    });
    return low_m;
}

WallSurface makeWall(const Mask& body) {
    const Grid& g = body.grid;
    WallSurface s;
    s.axis_m = findAxis(body);
    s.z_begin_m = g.origin_m.z;
    s.levels = std::max(2, int(std::ceil((g.dims.z - 1) * g.spacing_m.z / s.z_step_m)) + 1);
    s.radius_m.assign(std::size_t(s.angles * s.levels), 0.1);
    return s;
}

}  // namespace

bool isInsideFascia(const patient::Label& l) {
    using enum patient::Structure;
    using patient::Tissue;
    return l.tissue == Tissue::liver || l.tissue == Tissue::duct || l.tissue == Tissue::vessel ||
           l.structure == lung || l.structure == spleen || l.structure == kidney ||
           l.structure == gallbladder;
}

std::size_t WallSurface::nearestCell(const Vec3& at_m) const {
    const double turn = std::atan2(at_m.y - axis_m.y, at_m.x - axis_m.x) / kFullTurn;
    return cell(int(std::lround((at_m.z - z_begin_m) / z_step_m)), int(std::lround(turn * angles)));
}

double WallSurface::radiusAt(double phi, double z_m) const {
    double u = phi / kFullTurn * angles;
    u -= std::floor(u / angles) * angles;
    const double v = std::clamp((z_m - z_begin_m) / z_step_m, 0.0, double(levels - 1));
    const int a = int(u), z = std::min(int(v), levels - 2);
    const double fu = u - a, fv = v - z;
    const auto at = [&](int zz, int aa) { return radius_m[std::size_t(zz * angles + aa % angles)]; };
    return (1.0 - fv) * ((1.0 - fu) * at(z, a) + fu * at(z, a + 1)) +
           fv * ((1.0 - fu) * at(z + 1, a) + fu * at(z + 1, a + 1));
}

RadiusBounds computeRadiusBounds(const FasciaInput& in, const WallSurface& s, double nearest_m,
                                 double max_cells) {
    RadiusBounds bounds{outsideOrgans(in.organs, s, nearest_m, max_cells),
                        std::vector<double>(std::size_t(s.angles * s.levels), kFarOff_m)};
    forEachCoveredCell(in.bones, s, max_cells, [&](std::size_t cell, double r) {
        bounds.high_m[cell] = std::min(bounds.high_m[cell], r - kInsideBone_m);
    });
    return bounds;
}

bool boneNear(const RadiusBounds& bounds, const WallSurface& s, int level, int angle) {
    const int reach_z = int(0.024 / s.z_step_m), reach = 3;
    for (int dz = -reach_z; dz <= reach_z; ++dz)
        for (int da = -reach; da <= reach; ++da)
            if (bounds.high_m[s.cell(level + dz, angle + da)] < kFarOff_m) return true;
    return false;
}

Mask wallBones(const FasciaInput& in) {
    constexpr double kOrganOutside_m = 0.02, kMost = 0.5;
    const WallSurface s = makeWall(in.body);
    const std::vector<double> low_m = outsideOrgans(in.organs, s, 0.0, kMaxCells);
    const MaskRuns pieces(in.bones, Connectivity::corners);
    std::vector<double> within(pieces.voxelCounts().size(), 0.0);
    for (const Run& run : pieces.runs())
        for (std::uint32_t offset = run.begin; offset < run.end; ++offset) {
            const Vec3 p = in.bones.grid.centre(in.bones.grid.voxelAt(offset)), d = p - s.axis_m;
            within[run.component] += std::hypot(d.x, d.y) < low_m[s.nearestCell(p)] - kOrganOutside_m;
        }
    return pieces.where([&](std::size_t n) { return within[n] <= kMost * double(pieces.voxelCounts()[n]); });
}

WallSurface fitWall(const FasciaInput& in) {
    const Mask bones = wallBones(in);
    WallSurface s = makeWall(in.body);
    relax(s, observeWall({in.ct, in.body, bones, in.organs}, s));
    return s;
}

Mask insideWall(const WallSurface& s, const FasciaInput& in) {
    const Grid& g = in.body.grid;
    Mask inside(g);
    const std::vector<Column> columns = columnsAround(s.axis_m, g);
    const FloatVolume depth = distanceTo(inverted(in.body));
    // skinShell() adds half a voxel, and the fascia is one voxel thick.
    const double under_skin_m = kSkinShell_m + 1.5 * g.spacing_m.x;
    parallelVoxels(g, [&](const Index3& i) {
        const Column& column = columns[g.offset({i.x, i.y, 0})];
        const bool within =
            double(depth[i]) > under_skin_m && column.distance_m < s.radiusAt(column.angle, g.centre(i).z);
        inside[i] = in.body[i] && !in.bones[i] && (in.organs[i] || within);
    });
    keepLargestComponent(inside);
    // Add every bone and every cavity that is enclosed by `inside`: flood the complement from the left and
    // right faces of the image. All voxels that the flood does not reach are inside.
    Mask seeds(g);
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            seeds[{0, y, z}] = seeds[{g.dims.x - 1, y, z}] = 1;
    return inverted(floodFill(seeds, inverted(inside)));
}

Mask rasteriseBoundary(const Mask& inside, const Mask& free) {
    const Grid& g = inside.grid;
    Mask surface(g);
    const Index3 steps[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    forEachVoxel(g, [&](const Index3& a) {
        for (const Index3& step : steps) {
            const Index3 b = a + step;
            if (!g.contains(b) || inside[a] == inside[b]) continue;
            const Index3 outer = inside[a] ? b : a, inner = inside[a] ? a : b;
            surface[free[outer] ? outer : inner] = 1;
        }
    });
    return surface;
}

}  // namespace stylet::modeller
