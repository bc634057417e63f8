#include "app/modeller/segmentation/bone_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/segmentation/morphology.h"

namespace stylet::modeller {

namespace {

// The densest contrast medium of a portal venous scan, in a kidney, is below the first threshold except for
// noise, and always below the second.
constexpr std::int16_t kCortex_hu = 300, kSureCortex_hu = 350;
constexpr std::int16_t kSurface_hu = 180;  // halfway to spongy bone under a thin cortex
constexpr double kSureShare = 0.03;        // share of a bone's voxels
constexpr double kCortexReach_m = 0.002;
constexpr double kLeastCortex_ml = 0.03;
constexpr double kFrontWall_m = 0.035;  // depth below the skin: a sternum is less deep, a kidney is deeper

}  // namespace

// --- Cortex ---

bool isInFrontWall(const Mask& body, const Index3& at) {
    int y = body.grid.dims.y - 1;
    while (y > at.y && !body[{at.x, y, at.z}])
        --y;
    return (y - at.y) * body.grid.spacing_m.y < kFrontWall_m;
}

Mask bonePieces(const CtVolume& ct, const Mask& body) {
    Mask bright(ct.grid);
    for (std::size_t i = 0; i < bright.voxels.size(); ++i)
        bright.voxels[i] = body.voxels[i] && ct.voxels[i] > kBone_hu;
    const Pieces p = piecesOf(bright);
    std::vector<std::size_t> sure(p.size.size(), 0), front(p.size.size(), 0);
    const Grid& g = ct.grid;
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const auto n = std::size_t(p.number[{x, y, z}]);
                if (n == 0) continue;
                sure[n] += ct[{x, y, z}] > kSureCortex_hu;
                front[n] += 2 * y > g.dims.y && isInFrontWall(body, {x, y, z});
            }
    const double each_ml = voxelVolume_ml(g);
    for (std::size_t i = 0; i < bright.voxels.size(); ++i) {
        const auto n = std::size_t(p.number.voxels[i]);
        if (n == 0) continue;
        const double size = double(p.size[n]);
        bright.voxels[i] = size * each_ml >= kLeastCortex_ml &&
                           (double(sure[n]) > kSureShare * size || double(front[n]) > 0.8 * size);
    }
    return bright;
}

Mask shellOf(const CtVolume& ct, const Mask& pieces) {
    Mask cortex(ct.grid);
    for (std::size_t i = 0; i < cortex.voxels.size(); ++i)
        cortex.voxels[i] = pieces.voxels[i] && ct.voxels[i] > kCortex_hu;
    dropSmall(cortex, kLeastCortex_ml, Touch::corners);
    return both(dilated(cortex, std::max(kCortexReach_m, 1.01 * ct.grid.spacing_m.x)), pieces);
}

// --- What is enclosed ---

Met meets(const Mask& wall, Index3 at, const Index3& step, int count) {
    for (int n = 0; n < count; ++n) {
        at += step;
        if (!wall.grid.contains(at)) return Met::border;
        if (wall[at]) return Met::bone;
    }
    return Met::nothing;
}

namespace {

constexpr int kDirections = 26;

// The voxel steps to all neighbours, and their lengths.
struct Rays {
    std::array<Index3, kDirections> step;
    std::array<double, kDirections> length_m;
    explicit Rays(const Grid& g) {
        std::size_t n = 0;
        for (int z = -1; z <= 1; ++z)
            for (int y = -1; y <= 1; ++y)
                for (int x = -1; x <= 1; ++x) {
                    if (x == 0 && y == 0 && z == 0) continue;
                    step[n] = {x, y, z};
                    const Vec3 d = g.spacing_m * Vec3(step[n]);
                    length_m[n++] = std::sqrt(glm::dot(d, d));
                }
    }
};

// Voxels of `open` from which at least `share` of all directions hit the wall within `reach_m`. Directions
// that leave the section are not counted.
Mask enclosed(const Mask& wall, const Mask& open, double reach_m, double share) {
    const Grid& g = wall.grid;
    const Rays rays(g);
    const int allowed = int(kDirections * (1.0 - share));
    Mask out(g);
    forEachSlab(g.dims.z, [&](int z) {
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                if (!open[{x, y, z}]) continue;
                int missed = 0, met = 0;
                for (std::size_t n = 0; n < kDirections && missed <= allowed; ++n) {
                    const Met m = meets(wall, {x, y, z}, rays.step[n], int(reach_m / rays.length_m[n]));
                    missed += m == Met::nothing;
                    met += m == Met::bone;
                }
                out[{x, y, z}] = missed <= allowed && met >= share * (met + missed);
            }
    });
    return out;
}

// The region of the vertebral bodies: in front of the canal, an ellipse the size of a large lumbar
// vertebra.
Mask vertebraPlaces(const Grid& g, const std::vector<Vec3>& canal) {
    constexpr double kAside_m = 0.027, kDeep_m = 0.020, kBefore_m = 0.025, kSlice_m = 0.006;
    Mask places(g);
    forEachSlab(g.dims.z, [&](int z) {
        const double height_m = g.centre({0, 0, z}).z;
        const auto near = std::min_element(canal.begin(), canal.end(), [&](const Vec3& a, const Vec3& b) {
            return std::fabs(a.z - height_m) < std::fabs(b.z - height_m);
        });
        if (near == canal.end() || std::fabs(near->z - height_m) > 3.0 * kSlice_m) return;
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Vec3 d = g.centre({x, y, z}) - *near;
                const double u = d.x / kAside_m, v = (d.y - kBefore_m) / kDeep_m;
                places[{x, y, z}] = u * u + v * v < 1.0;
            }
    });
    return places;
}

}  // namespace

Mask withMarrow(const CtVolume& ct, const Mask& body, const Mask& pieces, const Mask& shell,
                const SpinalCanal& spine) {
    constexpr double kRib_m = 0.004, kNarrow_m = 0.010, kVertebra_m = 0.024;
    constexpr double kShare = 0.74, kBrightShare = 0.6, kBodyShare = 0.5, kNarrowShare = 0.8, kPeel_m = 0.003;
    constexpr std::int16_t kMarrow_hu = -100, kSpongy_hu = 120, kBody_hu = 150;
    const Grid& g = ct.grid;
    const Mask& canal = spine.voxels;
    const Mask vertebrae = vertebraPlaces(g, spine.centres_m), near = closed(shell, 0.012);
    Mask narrow = closed(shell, std::max(kRib_m, g.spacing_m.x)), bone = shell;
    Mask wall = both(pieces, dilated(shell, 0.004));
    const auto may = [&](std::size_t i) { return body.voxels[i] && !bone.voxels[i] && !canal.voxels[i]; };
    for (int round = 0; round < 3; ++round) {
        Mask open(g);
        for (std::size_t i = 0; i < open.voxels.size(); ++i)
            open.voxels[i] = may(i) && near.voxels[i] && ct.voxels[i] > kSpongy_hu;
        const Mask bright = both(open, pieces);
        bone = either(bone, enclosed(wall, open, kVertebra_m, kShare));
        bone = either(bone, enclosed(wall, bright, kVertebra_m, kBrightShare));
        Mask body_bone(g);
        for (std::size_t i = 0; i < body_bone.voxels.size(); ++i)
            body_bone.voxels[i] = may(i) && vertebrae.voxels[i] && ct.voxels[i] > kBody_hu;
        bone = either(bone, enclosed(wall, body_bone, kVertebra_m, kBodyShare));
        wall = either(wall, bone);
    }
    for (std::size_t i = 0; i < narrow.voxels.size(); ++i)
        narrow.voxels[i] = narrow.voxels[i] && may(i) && ct.voxels[i] > kMarrow_hu;
    bone = either(bone, enclosed(wall, narrow, kNarrow_m, kNarrowShare));
    Mask full = either(bone, canal);
    fillCavities(full);
    fillHolesPerSlice(full);  // closes rings of cortex, even as wide as the hip's
    for (std::size_t i = 0; i < full.voxels.size(); ++i)
        bone.voxels[i] =
            bone.voxels[i] || (full.voxels[i] && may(i) && near.voxels[i] && ct.voxels[i] > kMarrow_hu);
    // Marrow is surrounded by bone: remove dark voxels connected to the outside, as deep as the blur
    // reaches.
    Mask dark = bone;
    LabelVolume outside = inverted(either(bone, canal));
    for (std::size_t i = 0; i < dark.voxels.size(); ++i)
        dark.voxels[i] = bone.voxels[i] && ct.voxels[i] <= kSurface_hu;
    const Mask peeled = growSeeds(outside, dark, std::max(1, int(std::lround(kPeel_m / g.spacing_m.x))));
    return without(bone, peeled);
}

}  // namespace stylet::modeller
