#include "app/modeller/segmentation/bones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/bone_voxels.h"

namespace stylet::modeller {

namespace {

constexpr double kMinBone_ml = 0.3;

// --- Identification ---

// Returns the canal's centre in each slice, also where the canal is not visible. If no centre is visible at
// all, returns a point near the middle of the body's back.
std::vector<Vec3> interpolateCanal(const Grid& g, const std::vector<Vec3>& seen, const VoxelBox& body) {
    const Vec3 low = g.centre(body.low), high = g.centre(body.high);
    std::vector<Vec3> out(std::size_t(g.dims.z), Vec3(0.5 * (low.x + high.x), low.y + 0.06, 0.0));
    if (seen.empty()) return out;
    for (int z = 0; z < g.dims.z; ++z) {
        const double height_m = g.centre({0, 0, z}).z;
        // Use the mean of the visible centres within 15 mm in height or, if there are none, the nearest
        // centre.
        Vec3 sum(0.0), nearest = seen.front();
        double count = 0.0;
        for (const Vec3& p : seen) {
            if (std::fabs(p.z - height_m) < 0.015) sum += p, count += 1.0;
            if (std::fabs(p.z - height_m) < std::fabs(nearest.z - height_m)) nearest = p;
        }
        out[std::size_t(z)] = count > 0.0 ? sum / count : nearest;
    }
    return out;
}

constexpr double kSpineHalf_m = 0.028;  // half width of the spine: body, facets, most of a transverse process
constexpr double kSpineFront_m = 0.060, kSpineBack_m = 0.075;
constexpr double kRibAside_m = 0.052;  // lumbar transverse processes do not reach this far
constexpr double kPlate_m = 0.042;     // minimum vertical extent of a scapula or hip bone; ribs have less
constexpr int kAngles = 72;            // 5 degrees each, around the cage's axis

struct BonePiece {
    int number = 0;
    double volume_ml = 0.0;
    bool at_spine = false;
    double max_aside_m = 0.0, mean_aside_m = 0.0, mean_front_m = 0.0;  // from the canal
    std::array<double, kAngles> z_sum{}, count{}, z_low{}, z_high{};
    double z_mean = 0.0;
};

int angleBin(const Vec3& d) {
    const double turn = std::atan2(d.x, -d.y) / (2.0 * std::numbers::pi);  // 0 at the back, right is positive
    return std::clamp(int((turn + 0.5) * kAngles), 0, kAngles - 1);
}

struct Cage {
    const Grid& grid;
    std::vector<Vec3> canal;
    Vec3 axis_m;
};

std::vector<BonePiece> measureBones(const Components& p, const Mask& core, const Cage& cage) {
    const Grid& g = cage.grid;
    std::vector<BonePiece> out(p.size.size());
    for (BonePiece& b : out) {
        b.z_low.fill(std::numeric_limits<double>::max());
        b.z_high.fill(-std::numeric_limits<double>::max());
    }
    forEachVoxel(g, [&](const Index3& i) {
        const auto n = std::size_t(p.number[i]);
        if (n == 0) return;
        BonePiece& b = out[n];
        const Vec3 at = g.centre(i), from = at - cage.canal[std::size_t(i.z)];
        b.number = int(n);
        b.mean_aside_m += from.x;
        b.mean_front_m += from.y;
        b.max_aside_m = std::max(b.max_aside_m, std::fabs(from.x));
        b.z_mean += at.z;
        const auto a = std::size_t(angleBin(at - cage.axis_m));
        b.z_sum[a] += at.z;
        b.count[a] += 1.0;
        b.z_low[a] = std::min(b.z_low[a], at.z);
        b.z_high[a] = std::max(b.z_high[a], at.z);
        for (const int dx : {-1, 1})
            if (g.contains({i.x + dx, i.y, i.z}) && core[{i.x + dx, i.y, i.z}]) b.at_spine = true;
    });
    for (std::size_t n = 1; n < out.size(); ++n) {
        const double count = double(p.size[n]);
        out[n].volume_ml = count * voxelVolume_ml(g);
        out[n].mean_aside_m /= count;
        out[n].mean_front_m /= count;
        out[n].z_mean /= count;
    }
    return out;
}

enum class BoneKind { spine, rib, sternum, other };
// Minimum volume of a rib. Smaller pieces (calcified cartilage, tips) keep their label but are not counted.
constexpr double kMinRib_ml = 1.5;

BoneKind classifyPiece(const BonePiece& b, double front_m, double bottom_m) {
    double upright_m = 0.0, low_m = b.z_mean;
    for (std::size_t a = 0; a < kAngles; ++a)
        if (b.count[a] > 0.0) {
            upright_m = std::max(upright_m, b.z_high[a] - b.z_low[a]);
            low_m = std::min(low_m, b.z_low[a]);
        }
    const bool in_front = b.mean_front_m > 0.5 * front_m;
    if (in_front && std::fabs(b.mean_aside_m) < 0.045 && b.max_aside_m < 0.08) return BoneKind::sternum;
    if (b.max_aside_m < kRibAside_m && !in_front) return BoneKind::spine;
    // A piece that rises from the section's lower end without a connection to the spine is an iliac crest.
    const bool crest = low_m < bottom_m && !b.at_spine;
    return (upright_m > kPlate_m || crest) && !in_front ? BoneKind::other : BoneKind::rib;
}

// --- Ribs ---

// Mean height of a above b over the angles where both exist; 0 if there are none.
double heightAbove(const BonePiece& a, const BonePiece& b) {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = 0; k < kAngles; ++k)
        if (a.count[k] > 0.0 && b.count[k] > 0.0) {
            sum += a.z_sum[k] / a.count[k] - b.z_sum[k] / b.count[k];
            count += 1.0;
        }
    return count > 0.0 ? sum / count : 0.0;
}

// Returns the mean height of a piece at its angle closest to the back.
double backHeight(const BonePiece& b) {
    int best = kAngles;
    double z = b.z_mean;
    for (int k = 0; k < kAngles; ++k)
        if (b.count[std::size_t(k)] > 0.0 && std::abs(k - kAngles / 2) < best) {
            best = std::abs(k - kAngles / 2);
            z = b.z_sum[std::size_t(k)] / b.count[std::size_t(k)];
        }
    return z;
}

// Numbers the ribs. The lowest rib at the spine is the twelfth. Any other rib gets the number of the highest
// rib below it, minus one. If none is below it, it gets the number of the lowest rib above it, plus one. 0:
// unknown.
std::vector<int> numberRibs(const std::vector<const BonePiece*>& ribs) {
    std::vector<int> number(ribs.size(), 0);
    if (ribs.empty()) return number;
    std::size_t lowest = 0;
    for (std::size_t i = 1; i < ribs.size(); ++i) {
        const BonePiece &a = *ribs[i], &b = *ribs[lowest];
        if (a.at_spine != b.at_spine ? a.at_spine : backHeight(a) < backHeight(b)) lowest = i;
    }
    // Count along the longest chain of ribs down to the lowest one. It has at most twelve ribs, so twelve
    // rounds are enough.
    for (int round = 0; round < 12; ++round)
        for (std::size_t i = 0; i < ribs.size(); ++i) {
            int below = i == lowest ? 13 : 0;
            for (std::size_t j = 0; j < ribs.size() && i != lowest; ++j)
                if (number[j] > 0 && heightAbove(*ribs[i], *ribs[j]) > 0.0 &&
                    (below == 0 || number[j] < below))
                    below = number[j];
            if (below > 1) number[i] = below - 1;
        }
    for (std::size_t i = 0; i < ribs.size(); ++i) {
        if (number[i] > 0) continue;
        int over = 0;
        for (std::size_t j = 0; j < ribs.size(); ++j)
            if (heightAbove(*ribs[j], *ribs[i]) > 0.0) over = std::max(over, number[j]);
        if (over > 0) number[i] = std::min(over + 1, 12);
    }
    return number;
}

std::vector<Vec3> computeCentreLine(const std::vector<Vec3>& voxels, const Vec3& axis_m, bool right) {
    constexpr double kStep_m = 0.005;
    // First average by angle, then resample in even steps.
    std::array<Vec3, 4 * kAngles> sum{};
    std::array<double, 4 * kAngles> count{};
    for (const Vec3& p : voxels) {
        const Vec3 d = p - axis_m;
        const double turn = std::fabs(std::atan2(d.x, -d.y)) / (2.0 * std::numbers::pi);
        const auto a = std::size_t(std::clamp(int(turn * 4 * kAngles), 0, 4 * kAngles - 1));
        if ((d.x > 0.0) != right && turn > 0.05 && turn < 0.45) continue;
        sum[a] += p;
        count[a] += 1.0;
    }
    std::vector<Vec3> means, line;
    for (std::size_t a = 0; a < sum.size(); ++a)
        if (count[a] > 0.0) means.push_back(sum[a] / count[a]);
    for (std::size_t i = 0; i < means.size(); ++i) {
        const Vec3 p = means[i];
        const Vec3 d = line.empty() ? Vec3(1.0) : p - line.back();
        if (line.empty() || std::sqrt(glm::dot(d, d)) >= kStep_m) line.push_back(p);
    }
    return line;
}

std::string sideName(bool right) {
    return right ? "right" : "left";
}

void addRibs(const Components& p, const std::vector<const BonePiece*>& pieces, bool right, const Cage& cage,
             Bones& out) {
    if (pieces.empty()) {
        out.notes.push_back("no " + sideName(right) + " rib was found");
        return;
    }
    const std::vector<int> number = numberRibs(pieces);
    std::vector<std::vector<Vec3>> voxels(13);
    std::vector<Rib> ribs(13);
    std::vector<int> rib_of(p.size.size(), 0);
    for (std::size_t n = 0; n < pieces.size(); ++n) {
        if (number[n] == 0) continue;
        Rib& rib = ribs[std::size_t(number[n])];
        rib.right = right;
        rib.number = number[n];
        rib.at_spine = rib.at_spine || pieces[n]->at_spine;
        rib.volume_ml += pieces[n]->volume_ml;
        rib_of[std::size_t(pieces[n]->number)] = number[n];
    }
    const Grid& g = cage.grid;
    forEachVoxel(g, [&](const Index3& i) {
        if (const int n = rib_of[std::size_t(p.number[i])]; n > 0)
            voxels[std::size_t(n)].push_back(g.centre(i));
    });
    for (std::size_t n = 1; n < ribs.size(); ++n) {
        if (ribs[n].number == 0) continue;
        ribs[n].centre_line_m = computeCentreLine(voxels[n], cage.axis_m, right);
        out.ribs.push_back(ribs[n]);
    }
}

// Finds the discs: voxels in front of the canal with bone of the spine closely above and below.
Mask findDiscs(const CtVolume& ct, const Bones& bones, const std::vector<Vec3>& canal) {
    constexpr double kReach_m = 0.012, kFront_m = 0.008, kHalf_m = 0.026;
    constexpr std::int16_t kLow_hu = 40, kHigh_hu = 200;
    const Grid& g = ct.grid;
    const int reach = int(kReach_m / g.spacing_m.z);
    Mask discs(g);
    if (bones.canal_m.empty()) return discs;
    parallelVoxels(g, [&](const Index3& i) {
        const Vec3 d = g.centre(i) - canal[std::size_t(i.z)];
        if (d.y < kFront_m || d.y > kSpineFront_m || std::fabs(d.x) > kHalf_m) return;
        if (bones.all[i] || bones.canal[i] || ct[i] < kLow_hu || ct[i] > kHigh_hu) return;
        discs[i] = castRay(bones.spine, i, {0, 0, 1}, reach) == RayHit::bone &&
                   castRay(bones.spine, i, {0, 0, -1}, reach) == RayHit::bone;
    });
    discs = opened(discs, std::max(0.002, 1.01 * g.spacing_m.x));
    removeSmallComponents(discs, 0.5);
    return discs;
}

bool inSpine(const Vec3& from_canal) {
    return std::fabs(from_canal.x) < kSpineHalf_m && from_canal.y < kSpineFront_m &&
           from_canal.y > -kSpineBack_m;
}

// Drops bright pieces in front of the spine, and small ones well inside the ring of the large bones. They are
// calcifications in artery walls or bowel, not bone.
void removeStrayPieces(const Mask& body, const Cage& cage, bool canal_seen, Mask& bones) {
    constexpr double kBeforeCanal_m = 0.015, kWithin_m = 0.010;
    // The middle of a vertebra is at most 34 mm before that of the canal, even with its ribs, and the middle
    // of an aorta at least 46 mm. So is the middle of both sides' ribs, but they are not near the midline.
    constexpr double kAorta_m = 0.040, kMostOfIt = 0.9;
    const Grid& g = bones.grid;
    const Components p = findComponents(bones, Connectivity::corners);
    const auto small = [&](std::size_t n) { return double(p.size[n]) * voxelVolume_ml(g) < kMinRib_ml; };
    std::array<double, kAngles> ring_m;
    ring_m.fill(1.0);
    std::vector<Vec3> sum(p.size.size(), Vec3(0.0)), from_canal = sum;
    std::vector<double> central(p.size.size(), 0.0);
    forEachVoxel(g, [&](const Index3& i) {
        const auto n = std::size_t(p.number[i]);
        if (n == 0) return;
        const Vec3 at = g.centre(i), d = at - cage.canal[std::size_t(i.z)];
        sum[n] += at;
        from_canal[n] += d;
        central[n] += std::fabs(d.x) < kSpineHalf_m;
        if (small(n) || inSpine(d)) return;
        double& r = ring_m[std::size_t(angleBin(at - cage.axis_m))];
        r = std::min(r, std::hypot(at.x - cage.axis_m.x, at.y - cage.axis_m.y));
    });
    std::vector<bool> stray(p.size.size(), false);
    for (std::size_t n = 1; n < p.size.size(); ++n) {
        const double count = double(p.size[n]);
        const Vec3 at = sum[n] / count - cage.axis_m, d = from_canal[n] / count;
        if (inSpine(d)) {
            stray[n] = small(n) ? d.y > kBeforeCanal_m
                                : d.y > kAorta_m && central[n] > kMostOfIt * count && canal_seen;
            continue;
        }
        if (!small(n)) continue;
        const Index3 middle = g.nearest(sum[n] / count);
        if (d.y > 0.06 && isInFrontWall(body, middle)) continue;  // calcified rib cartilage
        // The ring's radius at the nearest angle where it is known.
        const int a = angleBin(at);
        double ring = 1.0;
        for (int k = 0; k <= kAngles / 2 && ring == 1.0; ++k)
            ring = std::min(ring_m[std::size_t((a + k) % kAngles)],
                            ring_m[std::size_t((a - k + kAngles) % kAngles)]);
        stray[n] = ring < 1.0 && std::hypot(at.x, at.y) < ring - kWithin_m;
    }
    bones = componentsWhere(p, [&](std::size_t n) { return !stray[n]; });
}

void classifyBones(const CtVolume& ct, const Mask& body, const VoxelBox& box, Bones& out) {
    const Grid& g = body.grid;
    const Vec3 low = g.centre(box.low), high = g.centre(box.high);
    Cage cage{g, interpolateCanal(g, out.canal_m, box), Vec3(0.0)};
    const Vec3 middle = cage.canal[cage.canal.size() / 2];
    cage.axis_m = {middle.x, 0.5 * (low.y + high.y), 0.0};

    removeStrayPieces(body, cage, !out.canal_m.empty(), out.all);
    Mask core(g), beside(g);
    forEachVoxel(g, [&](const Index3& i) {
        if (!out.all[i]) return;
        const Vec3 d = g.centre(i) - cage.canal[std::size_t(i.z)];
        (inSpine(d) ? core : beside)[i] = 1;
    });
    const Components p = findComponents(beside, Connectivity::corners);
    const std::vector<BonePiece> pieces = measureBones(p, core, cage);
    const double front_m = high.y - middle.y;
    std::vector<const BonePiece*> right, left;
    std::vector<BoneKind> kind(pieces.size(), BoneKind::spine);
    for (std::size_t n = 1; n < pieces.size(); ++n) {
        kind[n] = classifyPiece(pieces[n], front_m, g.origin_m.z + 1.5 * g.spacing_m.z);
        if (kind[n] == BoneKind::rib && pieces[n].volume_ml > kMinRib_ml)
            (pieces[n].mean_aside_m > 0.0 ? right : left).push_back(&pieces[n]);
    }
    out.spine = core;
    for (std::size_t i = 0; i < beside.voxels.size(); ++i) {
        const auto n = std::size_t(p.number.voxels[i]);
        if (n == 0) continue;
        const bool is_right = pieces[n].mean_aside_m > 0.0;
        Mask& to = kind[n] == BoneKind::spine     ? out.spine
                   : kind[n] == BoneKind::sternum ? out.sternum
                   : kind[n] == BoneKind::other   ? out.other
                   : is_right                     ? out.ribs_right
                                                  : out.ribs_left;
        to.voxels[i] = 1;
    }
    addRibs(p, right, true, cage, out);
    addRibs(p, left, false, cage, out);
    out.cartilage = findDiscs(ct, out, cage.canal);
    if (!out.ribs.empty())
        out.notes.push_back("ribs are counted upward from the lowest of each side, taken as the twelfth");
}

}  // namespace

Bones findBones(const CtVolume& ct, const Mask& body, const ScanBlur& blur) {
    const Grid& g = ct.grid;
    Bones out;
    for (Mask* m : {&out.all, &out.spine, &out.canal, &out.ribs_right, &out.ribs_left, &out.sternum,
                    &out.other, &out.cartilage})
        *m = Mask(g);
    const VoxelBox box = boundingBox(body);
    if (box.empty()) {
        out.notes.push_back("no body, so no bone");
        return out;
    }
    {
        const BoneScan scan(ct, body, blur);
        const BonePieces pieces = bonePieces(scan);
        const Mask shell = cortexShell(scan, pieces);
        SpinalCanal spine = findCanal(ct, shell, box);
        if (spine.centres_m.empty()) out.notes.push_back("the spinal canal does not show");
        out.all = withMarrow(scan, pieces.voxels, shell, spine);
        out.canal = std::move(spine.voxels);
        out.canal_m = std::move(spine.centres_m);
    }
    removeSmallComponents(out.all, kMinBone_ml, Connectivity::corners);
    classifyBones(ct, body, box, out);
    return out;
}

}  // namespace stylet::modeller
