#include "app/modeller/segmentation/bone_voxels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/image/morphology.h"
#include "base/parallel.h"

namespace stylet::modeller {

namespace {

// At 120 kV, the densest contrast medium of a portal venous scan, in a kidney, is below the first threshold
// except for noise, and always below the second.
constexpr std::int16_t kCortex_hu = 300, kSureCortex_hu = 350;
// The same in the sharpened scan. In a real patient, the cortex of the lowest ribs' tips exceeds it, even in
// a soft scan (at 300 HU, too; at 350 HU, 5 of 131 paths cross tips that are not found). 1 % of its kidneys'
// voxels exceed it, and 1 to 2 % exceed kCortex_hu in the scan.
constexpr float kSharpCortex_hu = 325.0f;
// Sharpening raises the noise, and random voxels above the limit would join to cortex in a vessel beside a
// bone. The limit is therefore at least so many deviations of that noise above the brightest usual vessel.
constexpr float kVessel_hu = 250.0f, kNoiseDeviations = 3.0f;
constexpr std::int16_t kSurface_hu = 180;  // halfway from soft tissue to spongy bone under a thin cortex
constexpr double kSureShare = 0.03;        // minimum share of a piece's voxels above kSureCortex_hu
constexpr double kCortexReach_m = 0.002;
constexpr double kMinCortex_ml = 0.03;
// At 80 kV a kidney is denser. It is beside the spine and behind the front third of the body, and unlike bone
// it is large and nearly even. Its vein may connect it to a vertebra, so that only its thick part shows:
// where a ball of kKidneyRadius_m fits into bright voxels, the standard deviation of a kidney is .11 to .18
// of its mean, and at most .28 of it is above kSureCortex_hu. Bones beside the spine of a real patient: from
// .34, and from .47 above. Vertebrae in voxels of 3 mm: from .175, .05 above; but they are in the middle of
// the body. Ribs are too thin for the ball; whole pieces must be larger than they are.
constexpr double kKidneyRadius_m = 0.005, kThickPart_ml = 4.0, kWholePiece_ml = 10.0;
constexpr double kKidneySureShare = 0.4, kKidneyDeviation = 0.21, kKidneyAside_m = 0.030;
constexpr double kKidneyRim_m = 0.006;  // bright voxels around the balls that belong to the kidney too
// Mean of the thick parts of a real patient's kidneys at 120 kV, of what is above kBone_hu in them. At 80 kV
// bone is up to a third denser, too.
constexpr double kKidney_hu = 245.0, kMaxLimitScale = 1.35;
constexpr double kFrontWall_m = 0.035;  // depth below the skin: a sternum is less deep, a kidney is deeper

}  // namespace

// --- Cortex ---

bool isInFrontWall(const Mask& body, const Index3& at) {
    int y = body.grid.dims.y - 1;
    while (y > at.y && !body[{at.x, y, at.z}])
        --y;
    return (y - at.y) * body.grid.spacing_m.y < kFrontWall_m;
}

namespace {

struct BrightPiece {
    double voxels = 0.0, sure = 0.0, front = 0.0, behind_front = 0.0, sum_x = 0.0, sum_hu = 0.0,
           sum_hu2 = 0.0;
    double mean_hu() const { return sum_hu / voxels; }
    double deviation() const {  // share of the mean
        return std::sqrt(std::max(0.0, sum_hu2 / voxels - mean_hu() * mean_hu())) / mean_hu();
    }
};

std::vector<BrightPiece> measurePieces(const BoneScan& scan, const Components& p) {
    const Grid& g = scan.ct.grid;
    const VoxelBox box = boundingBox(scan.body);
    const int front_third = box.high.y - (box.high.y - box.low.y) / 3;
    std::vector<BrightPiece> pieces(p.size.size());
    forEachVoxel(g, [&](const Index3& i) {
        if (p.number[i] == 0) return;
        BrightPiece& piece = pieces[std::size_t(p.number[i])];
        const double hu = scan.ct[i];
        piece.voxels += 1.0;
        piece.sure += hu > kSureCortex_hu;
        piece.behind_front += i.y < front_third;
        piece.front += 2 * i.y > g.dims.y && isInFrontWall(scan.body, i);
        piece.sum_x += i.x;
        piece.sum_hu += hu, piece.sum_hu2 += hu * hu;
    });
    return pieces;
}

double middleOfBody_x(const Mask& body) {
    double sum_x = 0.0, voxels = 0.0;
    forEachVoxel(body.grid, [&](const Index3& i) {
        if (body[i]) sum_x += i.x, voxels += 1.0;
    });
    return sum_x / voxels;
}

struct BrightKidneys {
    Mask voxels;
    double limit_scale = 1.0;
};

// The parts of `bright` that are thick enough for a ball. Noise would leave dark voxels in every ball, so a
// mean decides what is bright.
Mask thickParts(const CtVolume& ct, const Mask& bright) {
    const Grid& g = ct.grid;
    const VoxelBox box = boxAround(bright, int(std::ceil(kKidneyRadius_m / g.spacing_m.x)) + 2);
    Mask thick(g);
    if (box.empty()) return thick;
    const FloatVolume mean_hu = boxMean(toFloat(cropped(ct, box)), 1);
    const Mask dense =
        maskWhere(mean_hu.grid, [&](std::size_t i) { return mean_hu.voxels[i] > float(kBone_hu); });
    paste(opened(dense, kKidneyRadius_m), box.low, thick);
    return thick;
}

BrightKidneys findBrightKidneys(const BoneScan& scan, const Mask& bright) {
    const Grid& g = scan.ct.grid;
    const double middle_x = middleOfBody_x(scan.body);
    const auto aside_m = [&](const BrightPiece& piece) {
        return (piece.sum_x / piece.voxels - middle_x) * g.spacing_m.x;
    };
    const auto isKidney = [&](const BrightPiece& piece, double min_ml) {
        return piece.voxels * voxelVolume_ml(g) > min_ml && std::fabs(aside_m(piece)) > kKidneyAside_m &&
               piece.behind_front > 0.5 * piece.voxels && piece.sure < kKidneySureShare * piece.voxels &&
               piece.deviation() < kKidneyDeviation;
    };
    const auto kidneysAmong = [&](const Components& p, const std::vector<BrightPiece>& pieces,
                                  double min_ml) {
        return componentsWhere(p, [&](std::size_t n) { return isKidney(pieces[n], min_ml); });
    };
    const Components whole = findComponents(bright), thick = findComponents(thickParts(scan.ct, bright));
    const std::vector<BrightPiece> parts = measurePieces(scan, thick);
    const Mask seeds = intersect(kidneysAmong(thick, parts, kThickPart_ml), bright);
    // One side alone may be a bowel full of contrast medium, which says nothing about bones.
    const BrightPiece *right = nullptr, *left = nullptr;
    for (const BrightPiece& piece : parts)
        if (isKidney(piece, kThickPart_ml))
            if (const BrightPiece*& largest = aside_m(piece) > 0.0 ? right : left;
                !largest || largest->voxels < piece.voxels)
                largest = &piece;
    const double hu = right && left ? std::min(right->mean_hu(), left->mean_hu()) : 0.0;
    const int rim = std::max(1, int(std::lround(kKidneyRim_m / g.spacing_m.x)));
    return {
        unite(kidneysAmong(whole, measurePieces(scan, whole), kWholePiece_ml), growSeeds(seeds, bright, rim)),
        std::clamp(hu / kKidney_hu, 1.0, kMaxLimitScale)};
}

}  // namespace

BonePieces bonePieces(const BoneScan& scan) {
    const CtVolume& ct = scan.ct;
    const Mask bright =
        maskWhere(ct.grid, [&](std::size_t i) { return scan.body.voxels[i] && ct.voxels[i] > kBone_hu; });
    const BrightKidneys kidneys = findBrightKidneys(scan, bright);
    const Components p = findComponents(subtract(bright, kidneys.voxels));
    const std::vector<BrightPiece> pieces = measurePieces(scan, p);
    const auto isBonePiece = [&](std::size_t n) {
        const BrightPiece& piece = pieces[n];
        return piece.voxels * voxelVolume_ml(ct.grid) >= kMinCortex_ml &&
               (piece.sure > kSureShare * piece.voxels || piece.front > 0.8 * piece.voxels);
    };
    return {componentsWhere(p, isBonePiece), kidneys.limit_scale};
}

namespace {

// See kNoiseDeviations. The noise is measured in what is as dense as muscle.
float sharpCortexLimit(const BoneScan& scan, float limit_scale) {
    constexpr std::int16_t kDarkestMuscle_hu = 0, kBrightestMuscle_hu = 110;
    const Mask muscle = maskWhere(scan.ct.grid, [&](std::size_t i) {
        const std::int16_t hu = scan.ct.voxels[i];
        return scan.body.voxels[i] && hu > kDarkestMuscle_hu && hu < kBrightestMuscle_hu;
    });
    const double noise_hu = measureNoise_hu(scan.sharp, muscle);
    const float least = limit_scale * kSharpCortex_hu;
    return std::isnan(noise_hu)
               ? least
               : std::max(least, limit_scale * kVessel_hu + kNoiseDeviations * float(noise_hu));
}

}  // namespace

Mask cortexShell(const BoneScan& scan, const BonePieces& pieces) {
    const Grid& g = scan.ct.grid;
    const auto scale = float(pieces.limit_scale);
    const float limit_hu = scale * float(kCortex_hu), sharp_limit_hu = sharpCortexLimit(scan, scale);
    Mask cortex = maskWhere(g, [&](std::size_t i) {
        return pieces.voxels.voxels[i] &&
               (float(scan.ct.voxels[i]) > limit_hu || scan.sharp.voxels[i] > sharp_limit_hu);
    });
    removeSmallComponents(cortex, kMinCortex_ml, Connectivity::corners);
    return intersect(dilated(cortex, std::max(kCortexReach_m, 1.01 * g.spacing_m.x)), pieces.voxels);
}

// --- Enclosed voxels ---

RayHit castRay(const Mask& wall, Index3 at, const Index3& step, int count) {
    for (int n = 0; n < count; ++n) {
        at += step;
        if (!wall.grid.contains(at)) return RayHit::border;
        if (wall[at]) return RayHit::bone;
    }
    return RayHit::nothing;
}

namespace {

constexpr int kDirections = 26;

// The voxel steps to all neighbours, and their lengths.
struct RayDirections {
    std::array<Index3, kDirections> step;
    std::array<double, kDirections> length_m;
    explicit RayDirections(const Grid& g) {
        std::size_t n = 0;
        forEachVoxel(VoxelBox{Index3(-1), Index3(1)}, [&](const Index3& i) {
            if (i == Index3(0)) return;
            step[n] = i;
            const Vec3 d = g.spacing_m * Vec3(i);
            length_m[n++] = std::sqrt(glm::dot(d, d));
        });
    }
};

// Voxels of `open` from which at least `share` of all directions hit the wall within `reach_m`. Directions
// that leave the volume are not counted.
Mask enclosed(const Mask& wall, const Mask& open, double reach_m, double share) {
    const Grid& g = wall.grid;
    const RayDirections rays(g);
    const int allowed = int(kDirections * (1.0 - share));
    Mask out(g);
    parallelVoxels(g, [&](const Index3& i) {
        if (!open[i]) return;
        int missed = 0, met = 0;
        for (std::size_t n = 0; n < kDirections && missed <= allowed; ++n) {
            const RayHit m = castRay(wall, i, rays.step[n], int(reach_m / rays.length_m[n]));
            missed += m == RayHit::nothing;
            met += m == RayHit::bone;
        }
        out[i] = missed <= allowed && met >= share * (met + missed);
    });
    return out;
}

// The region of the vertebral bodies: in front of the canal, an ellipse the size of a large lumbar
// vertebra.
Mask vertebraRegion(const Grid& g, const std::vector<Vec3>& canal) {
    constexpr double kAside_m = 0.027, kDeep_m = 0.020, kBefore_m = 0.025, kSlice_m = 0.006;
    Mask region(g);
    parallelFor(processorCount(), g.dims.z, [&](int z) {
        const double height_m = g.centre({0, 0, z}).z;
        const auto near = std::min_element(canal.begin(), canal.end(), [&](const Vec3& a, const Vec3& b) {
            return std::fabs(a.z - height_m) < std::fabs(b.z - height_m);
        });
        if (near == canal.end() || std::fabs(near->z - height_m) > 3.0 * kSlice_m) return;
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Vec3 d = g.centre({x, y, z}) - *near;
                const double u = d.x / kAside_m, v = (d.y - kBefore_m) / kDeep_m;
                region[{x, y, z}] = u * u + v * v < 1.0;
            }
    });
    return region;
}

}  // namespace

Mask smoothedSurface(Mask bone, const Mask& open, const ScanBlur& blur) {
    constexpr int kPasses = 2;
    // Below one half, because smoothing makes a convex bone thinner.
    constexpr float kMinShare = 0.45f;
    const Grid& g = bone.grid;
    if (!hidesBoneBorders(g, blur)) return bone;
    FloatVolume share = toFloat(bone);
    for (int pass = 0; pass < kPasses; ++pass)
        for (const int axis : {0, 1, 2})
            parallelLines(processorCount(), g.dims, axis, share.voxels.data(), smoothLine);
    const Mask smooth = maskWhere(
        g, [&](std::size_t i) { return share.voxels[i] > kMinShare && (bone.voxels[i] || open.voxels[i]); });
    return unite(smooth, subtract(std::move(bone), dilated(smooth, 1.01 * g.spacing_m.x)));
}

Mask withMarrow(const BoneScan& scan, const Mask& pieces, const Mask& shell, const SpinalCanal& spine) {
    const CtVolume& ct = scan.ct;
    const Mask& body = scan.body;
    constexpr double kRib_m = 0.004, kNarrow_m = 0.010, kVertebra_m = 0.024;
    constexpr double kShare = 0.74, kBrightShare = 0.6, kBodyShare = 0.5, kNarrowShare = 0.8, kPeel_m = 0.003;
    constexpr std::int16_t kMarrow_hu = -100, kSpongy_hu = 120, kBody_hu = 150;
    const Grid& g = ct.grid;
    const Mask& canal = spine.voxels;
    const Mask vertebrae = vertebraRegion(g, spine.centres_m), near = closed(shell, 0.012);
    Mask narrow = closed(shell, std::max(kRib_m, g.spacing_m.x)), bone = shell;
    Mask wall = intersect(pieces, dilated(shell, 0.004));
    const auto fillable = [&](std::size_t i) {
        return body.voxels[i] && !bone.voxels[i] && !canal.voxels[i];
    };
    for (int round = 0; round < 3; ++round) {
        const Mask open = maskWhere(
            g, [&](std::size_t i) { return fillable(i) && near.voxels[i] && ct.voxels[i] > kSpongy_hu; });
        const Mask bright = intersect(open, pieces);
        bone = unite(bone, enclosed(wall, open, kVertebra_m, kShare));
        bone = unite(bone, enclosed(wall, bright, kVertebra_m, kBrightShare));
        const Mask body_bone = maskWhere(
            g, [&](std::size_t i) { return fillable(i) && vertebrae.voxels[i] && ct.voxels[i] > kBody_hu; });
        bone = unite(bone, enclosed(wall, body_bone, kVertebra_m, kBodyShare));
        wall = unite(wall, bone);
    }
    for (std::size_t i = 0; i < narrow.voxels.size(); ++i)
        narrow.voxels[i] = narrow.voxels[i] && fillable(i) && ct.voxels[i] > kMarrow_hu;
    bone = unite(bone, enclosed(wall, narrow, kNarrow_m, kNarrowShare));
    Mask full = unite(bone, canal);
    fillCavities(full);
    fillHolesPerSlice(full);  // closes rings of cortex, even as wide as the hip's
    for (std::size_t i = 0; i < full.voxels.size(); ++i)
        bone.voxels[i] =
            bone.voxels[i] || (full.voxels[i] && fillable(i) && near.voxels[i] && ct.voxels[i] > kMarrow_hu);
    // Marrow is surrounded by bone, so dark voxels connected to the outside are not marrow. Remove them
    // down to kPeel_m below the surface; the scan's blur reaches so deep.
    const Mask dark =
        maskWhere(g, [&](std::size_t i) { return bone.voxels[i] && ct.voxels[i] <= kSurface_hu; });
    const LabelVolume outside = inverted(unite(bone, canal));
    const Mask peeled = growSeeds(outside, dark, std::max(1, int(std::lround(kPeel_m / g.spacing_m.x))));
    return smoothedSurface(withoutBlurredRim(scan, subtract(bone, peeled), canal), subtract(body, canal),
                           scan.blur);
}

}  // namespace stylet::modeller
