#include "app/modeller/segmentation/bones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "app/modeller/segmentation/bone_voxels.h"
#include "app/modeller/segmentation/morphology.h"

namespace stylet::modeller {

namespace {

constexpr double kLeastBone_ml = 0.3;

// --- Which bone it is ---

// The canal's centre in each slice, extended to slices where it is not visible. Without a canal, a point
// near the middle of the body's back.
std::vector<Vec3> canalAtSlices(const Grid& g, const std::vector<Vec3>& seen, const VoxelBox& body) {
    const Vec3 low = g.centre(body.low), high = g.centre(body.high);
    std::vector<Vec3> out(std::size_t(g.dims.z), Vec3(0.5 * (low.x + high.x), low.y + 0.06, 0.0));
    if (seen.empty()) return out;
    for (int z = 0; z < g.dims.z; ++z) {
        const double height_m = g.centre({0, 0, z}).z;
        // The mean of the visible centres within 15 mm, else the nearest.
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

constexpr double kSpineHalf_m = 0.028;  // half width: body, facets, most of a transverse process
constexpr double kSpineFront_m = 0.060, kSpineBack_m = 0.075;
constexpr double kRibAside_m = 0.052;  // lumbar transverse processes do not reach this far
constexpr double kPlate_m = 0.042;     // vertical extent of a shoulder or hip blade; ribs are below it
constexpr int kAngles = 72;            // 5 degrees each, around the cage's axis

struct BonePiece {
    int number = 0;
    double volume_ml = 0.0;
    bool at_spine = false;
    double furthest_m = 0.0, mean_aside_m = 0.0, mean_front_m = 0.0;  // from the canal
    std::array<double, kAngles> z_sum{}, count{}, z_low{}, z_high{};
    double z_mean = 0.0;
};

int angleOf(const Vec3& d) {
    const double turn = std::atan2(d.x, -d.y) / (2.0 * std::numbers::pi);  // 0 at the back, right is positive
    return std::clamp(int((turn + 0.5) * kAngles), 0, kAngles - 1);
}

struct Cage {
    const Grid& grid;
    std::vector<Vec3> canal;
    Vec3 axis_m;
};

std::vector<BonePiece> measuredBones(const Pieces& p, const Mask& core, const Cage& cage) {
    const Grid& g = cage.grid;
    std::vector<BonePiece> out(p.size.size());
    for (BonePiece& b : out) {
        b.z_low.fill(std::numeric_limits<double>::max());
        b.z_high.fill(-std::numeric_limits<double>::max());
    }
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                const auto n = std::size_t(p.number[i]);
                if (n == 0) continue;
                BonePiece& b = out[n];
                const Vec3 at = g.centre(i), from = at - cage.canal[std::size_t(z)];
                b.number = int(n);
                b.mean_aside_m += from.x;
                b.mean_front_m += from.y;
                b.furthest_m = std::max(b.furthest_m, std::fabs(from.x));
                b.z_mean += at.z;
                const auto a = std::size_t(angleOf(at - cage.axis_m));
                b.z_sum[a] += at.z;
                b.count[a] += 1.0;
                b.z_low[a] = std::min(b.z_low[a], at.z);
                b.z_high[a] = std::max(b.z_high[a], at.z);
                for (const int dx : {-1, 1})
                    if (g.contains({x + dx, y, z}) && core[{x + dx, y, z}]) b.at_spine = true;
            }
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
constexpr double kLeastRib_ml = 1.5;

BoneKind kindOf(const BonePiece& b, double front_m, double bottom_m) {
    double upright_m = 0.0, low_m = b.z_mean;
    for (std::size_t a = 0; a < kAngles; ++a)
        if (b.count[a] > 0.0) {
            upright_m = std::max(upright_m, b.z_high[a] - b.z_low[a]);
            low_m = std::min(low_m, b.z_low[a]);
        }
    const bool in_front = b.mean_front_m > 0.5 * front_m;
    if (in_front && std::fabs(b.mean_aside_m) < 0.045 && b.furthest_m < 0.08) return BoneKind::sternum;
    if (b.furthest_m < kRibAside_m && !in_front) return BoneKind::spine;
    // A piece that rises from the section's lower end without a connection to the spine is an iliac crest.
    const bool crest = low_m < bottom_m && !b.at_spine;
    return (upright_m > kPlate_m || crest) && !in_front ? BoneKind::other : BoneKind::rib;
}

// --- Ribs ---

// Mean height of a above b over the angles where both exist; 0 if there are none.
double above(const BonePiece& a, const BonePiece& b) {
    double sum = 0.0, count = 0.0;
    for (std::size_t k = 0; k < kAngles; ++k)
        if (a.count[k] > 0.0 && b.count[k] > 0.0) {
            sum += a.z_sum[k] / a.count[k] - b.z_sum[k] / b.count[k];
            count += 1.0;
        }
    return count > 0.0 ? sum / count : 0.0;
}

// The height at which a piece leaves the back, or the height of its back end.
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

// Numbers the ribs. The lowest rib at the spine is the twelfth. Any other is numbered one above the highest
// rib below it or, if there is none, one below the lowest rib above it. 0: unknown.
std::vector<int> numbered(const std::vector<const BonePiece*>& ribs) {
    std::vector<int> number(ribs.size(), 0);
    if (ribs.empty()) return number;
    std::size_t lowest = 0;
    for (std::size_t i = 1; i < ribs.size(); ++i) {
        const BonePiece &a = *ribs[i], &b = *ribs[lowest];
        if (a.at_spine != b.at_spine ? a.at_spine : backHeight(a) < backHeight(b)) lowest = i;
    }
    // The longest chain down to the lowest rib. It is complete after as many rounds as there are ribs.
    for (int round = 0; round < 12; ++round)
        for (std::size_t i = 0; i < ribs.size(); ++i) {
            int below = i == lowest ? 13 : 0;
            for (std::size_t j = 0; j < ribs.size() && i != lowest; ++j)
                if (number[j] > 0 && above(*ribs[i], *ribs[j]) > 0.0 && (below == 0 || number[j] < below))
                    below = number[j];
            if (below > 1) number[i] = below - 1;
        }
    for (std::size_t i = 0; i < ribs.size(); ++i) {
        if (number[i] > 0) continue;
        int over = 0;
        for (std::size_t j = 0; j < ribs.size(); ++j)
            if (above(*ribs[j], *ribs[i]) > 0.0) over = std::max(over, number[j]);
        if (over > 0) number[i] = std::min(over + 1, 12);
    }
    return number;
}

std::vector<Vec3> centreLine(const std::vector<Vec3>& voxels, const Vec3& axis_m, bool right) {
    constexpr double kStep_m = 0.005;
    // Means by angle first, then resampled in even steps.
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

void nameRibs(const Pieces& p, const std::vector<const BonePiece*>& pieces, bool right, const Cage& cage,
              Bones& out) {
    if (pieces.empty()) {
        out.notes.push_back("no " + sideName(right) + " rib was found");
        return;
    }
    const std::vector<int> number = numbered(pieces);
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
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x)
                if (const int n = rib_of[std::size_t(p.number[{x, y, z}])]; n > 0)
                    voxels[std::size_t(n)].push_back(g.centre({x, y, z}));
    for (std::size_t n = 1; n < ribs.size(); ++n) {
        if (ribs[n].number == 0) continue;
        ribs[n].centre_line_m = centreLine(voxels[n], cage.axis_m, right);
        out.ribs.push_back(ribs[n]);
    }
}

// The discs: between vertebral bodies, with bone a disc's height above and below, in front of the canal.
Mask discsOf(const CtVolume& ct, const Bones& bones, const std::vector<Vec3>& canal) {
    constexpr double kReach_m = 0.012, kFront_m = 0.008, kHalf_m = 0.026;
    constexpr std::int16_t kLow_hu = 40, kHigh_hu = 200;
    const Grid& g = ct.grid;
    const int reach = int(kReach_m / g.spacing_m.z);
    Mask discs(g);
    if (bones.canal_m.empty()) return discs;
    forEachSlab(g.dims.z, [&](int z) {
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                const Vec3 d = g.centre(i) - canal[std::size_t(z)];
                if (d.y < kFront_m || d.y > kSpineFront_m || std::fabs(d.x) > kHalf_m) continue;
                if (bones.all[i] || bones.canal[i] || ct[i] < kLow_hu || ct[i] > kHigh_hu) continue;
                discs[i] = meets(bones.spine, i, {0, 0, 1}, reach) == Met::bone &&
                           meets(bones.spine, i, {0, 0, -1}, reach) == Met::bone;
            }
    });
    discs = opened(discs, std::max(0.002, 1.01 * g.spacing_m.x));
    dropSmall(discs, 0.5);
    return discs;
}

bool inSpine(const Vec3& from_canal) {
    return std::fabs(from_canal.x) < kSpineHalf_m && from_canal.y < kSpineFront_m &&
           from_canal.y > -kSpineBack_m;
}

// Drops small bright pieces in front of the spine or well inside the ring of the large bones. They are
// calcifications in artery walls or bowel, not bone.
void dropStray(const Mask& body, const Cage& cage, Mask& bones) {
    constexpr double kBeforeCanal_m = 0.015, kWithin_m = 0.010;
    const Grid& g = bones.grid;
    const Pieces p = piecesOf(bones, Touch::corners);
    const auto small = [&](std::size_t n) { return double(p.size[n]) * voxelVolume_ml(g) < kLeastRib_ml; };
    std::array<double, kAngles> ring_m;
    ring_m.fill(1.0);
    std::vector<Vec3> sum(p.size.size(), Vec3(0.0)), from_canal = sum;
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const auto n = std::size_t(p.number[{x, y, z}]);
                if (n == 0) continue;
                const Vec3 at = g.centre({x, y, z}), d = at - cage.canal[std::size_t(z)];
                sum[n] += at;
                from_canal[n] += d;
                if (small(n) || inSpine(d)) continue;
                double& r = ring_m[std::size_t(angleOf(at - cage.axis_m))];
                r = std::min(r, std::hypot(at.x - cage.axis_m.x, at.y - cage.axis_m.y));
            }
    std::vector<bool> stray(p.size.size(), false);
    for (std::size_t n = 1; n < p.size.size(); ++n) {
        if (!small(n)) continue;
        const double count = double(p.size[n]);
        const Vec3 at = sum[n] / count - cage.axis_m, d = from_canal[n] / count;
        if (inSpine(d)) {
            stray[n] = d.y > kBeforeCanal_m;
            continue;
        }
        const Index3 middle = g.nearest(sum[n] / count);
        if (d.y > 0.06 && isInFrontWall(body, middle)) continue;  // calcified rib cartilage
        // The ring's radius at the nearest angle where it is known.
        const int a = angleOf(at);
        double ring = 1.0;
        for (int k = 0; k <= kAngles / 2 && ring == 1.0; ++k)
            ring = std::min(ring_m[std::size_t((a + k) % kAngles)],
                            ring_m[std::size_t((a - k + kAngles) % kAngles)]);
        stray[n] = ring < 1.0 && std::hypot(at.x, at.y) < ring - kWithin_m;
    }
    for (std::size_t i = 0; i < bones.voxels.size(); ++i)
        if (bones.voxels[i] && stray[std::size_t(p.number.voxels[i])]) bones.voxels[i] = 0;
}

void tellApart(const CtVolume& ct, const Mask& body, const VoxelBox& box, Bones& out) {
    const Grid& g = body.grid;
    const Vec3 low = g.centre(box.low), high = g.centre(box.high);
    Cage cage{g, canalAtSlices(g, out.canal_m, box), Vec3(0.0)};
    const Vec3 middle = cage.canal[cage.canal.size() / 2];
    cage.axis_m = {middle.x, 0.5 * (low.y + high.y), 0.0};

    dropStray(body, cage, out.all);
    Mask core(g), beside(g);
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                if (!out.all[i]) continue;
                const Vec3 d = g.centre(i) - cage.canal[std::size_t(z)];
                (inSpine(d) ? core : beside)[i] = 1;
            }
    const Pieces p = piecesOf(beside, Touch::corners);
    const std::vector<BonePiece> pieces = measuredBones(p, core, cage);
    const double front_m = high.y - middle.y;
    std::vector<const BonePiece*> right, left;
    std::vector<BoneKind> kind(pieces.size(), BoneKind::spine);
    for (std::size_t n = 1; n < pieces.size(); ++n) {
        kind[n] = kindOf(pieces[n], front_m, g.origin_m.z + 1.5 * g.spacing_m.z);
        if (kind[n] == BoneKind::rib && pieces[n].volume_ml > kLeastRib_ml)
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
    nameRibs(p, right, true, cage, out);
    nameRibs(p, left, false, cage, out);
    out.cartilage = discsOf(ct, out, cage.canal);
    if (!out.ribs.empty())
        out.notes.push_back("ribs are counted upward from the lowest of each side, taken as the twelfth");
}

}  // namespace

Bones findBones(const CtVolume& ct, const Mask& body) {
    const Grid& g = ct.grid;
    Bones out;
    for (Mask* m : {&out.all, &out.spine, &out.canal, &out.ribs_right, &out.ribs_left, &out.sternum,
                    &out.other, &out.cartilage})
        *m = Mask(g);
    const VoxelBox box = boxOf(body);
    if (box.empty()) {
        out.notes.push_back("no body, so no bone");
        return out;
    }
    const Mask pieces = bonePieces(ct, body);
    const Mask shell = shellOf(ct, pieces);
    SpinalCanal spine = findCanal(ct, shell, box);
    if (spine.centres_m.empty()) out.notes.push_back("the spinal canal does not show");
    out.all = withMarrow(ct, body, pieces, shell, spine);
    out.canal = std::move(spine.voxels);
    out.canal_m = std::move(spine.centres_m);
    dropSmall(out.all, kLeastBone_ml, Touch::corners);
    tellApart(ct, body, box, out);
    return out;
}

Mask costalCartilage(const CtVolume& ct, const Mask& body, const Mask& inside, const Bones& bones) {
    // Muscle is below 75 HU. An adult's cartilage is at 90 to 130 HU, and more where calcified. In wide
    // voxels the edges of cartilage look like muscle, and muscle beside a rib looks like cartilage.
    constexpr float kLow_hu = 78.0f, kHigh_hu = 500.0f;
    constexpr double kWidest_m = 0.00125;
    constexpr double kSkin_m = 0.006, kThick_m = 0.0025, kJoin_m = 0.004, kLeast_ml = 0.5;
    const Grid& g = ct.grid;
    if (g.spacing_m.x > kWidest_m) return Mask(g);
    FloatVolume smooth(g);
    for (std::size_t i = 0; i < smooth.voxels.size(); ++i)
        smooth.voxels[i] = float(ct.voxels[i]);
    smooth = boxMean(smooth, 1);
    Mask ends = either(bones.ribs_right, either(bones.ribs_left, bones.sternum));
    const Mask taken = either(either(inside, bones.all), dilated(bones.spine, 0.010));
    Mask found = eroded(body, kSkin_m);
    for (std::size_t i = 0; i < found.voxels.size(); ++i)
        found.voxels[i] =
            found.voxels[i] && !taken.voxels[i] && smooth.voxels[i] > kLow_hu && smooth.voxels[i] < kHigh_hu;
    // Cartilage begins where the ribs end, in front of the body's middle. Behind are muscles and, beyond an
    // uncertain fascia, kidneys.
    const VoxelBox box = boxOf(body);
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y <= (box.low.y + box.high.y) / 2; ++y)
            for (int x = 0; x < g.dims.x; ++x)
                found[{x, y, z}] = 0;
    // A rib's blurred rim is as dense as cartilage: count it only as part of a thicker piece.
    const Mask rim = dilated(bones.all, 1.01 * g.spacing_m.x);
    const Mask core = opened(without(found, rim), std::max(kThick_m, 1.01 * g.spacing_m.x));
    found = both(found, dilated(core, 2.0 * g.spacing_m.x));
    ends = both(dilated(ends, kJoin_m), found);
    found = piecesWith(found, ends);
    dropSmall(found, kLeast_ml);
    return found;
}

}  // namespace stylet::modeller
