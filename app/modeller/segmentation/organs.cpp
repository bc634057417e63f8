#include "app/modeller/segmentation/organs.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/organ_scene.h"
#include "base/parallel.h"

namespace stylet::modeller {

namespace {

constexpr double kUsualOrgan_hu = 110.0;  // liver and spleen, in the portal venous phase

// 1 at `typical`, falling linearly to 0 at `low` and `high`.
double plausible(double v, double low, double typical, double high) {
    return std::clamp(v < typical ? (v - low) / (typical - low) : (high - v) / (high - typical), 0.0, 1.0);
}

// Weighted histogram with bins of 1 HU. mode(): the centre of the five adjacent bins with the largest sum.
class HuHistogram {
  public:
    HuHistogram(int low_hu, int high_hu) : low_hu_(low_hu), count_(std::size_t(high_hu - low_hu), 0.0) {}
    void add(float hu, double weight) {
        if (const auto k = std::floor(hu) - float(low_hu_); k >= 0.0f && k < float(count_.size()))
            count_[std::size_t(k)] += weight;
    }
    std::optional<double> mode() const {
        std::optional<double> best;
        double highest = 0.0;
        for (std::size_t k = 2; k + 2 < count_.size(); ++k) {
            const double sum = count_[k - 2] + count_[k - 1] + count_[k] + count_[k + 1] + count_[k + 2];
            if (sum > highest) highest = sum, best = low_hu_ + double(k) + 0.5;
        }
        return best;
    }

  private:
    int low_hu_;
    std::vector<double> count_;
};

// Returns the HU of the liver, if at least 100 ml of it are known. Otherwise returns the most frequent value
// denser than muscle.
double estimateParenchyma(const OrganScene& s, const Mask& bone) {
    constexpr int kDenserThanMuscle_hu = 70, kMax_hu = 160;
    const bool known = volume_ml(s.liver) > 100.0;
    HuHistogram h(known ? 0 : kDenserThanMuscle_hu, known ? 2 * kMax_hu : kMax_hu);
    for (std::size_t i = 0; i < s.smooth_hu.voxels.size(); ++i)
        if (!bone.voxels[i] && (known ? s.liver.voxels[i] : s.inside.voxels[i]))
            h.add(s.smooth_hu.voxels[i], 1.0);
    return h.mode().value_or(kUsualOrgan_hu);
}

FoundOrgan notFound(const std::string& name, const std::string& why) {
    return {name, {}, 0.0, name + ": " + why};
}

// Returns the piece with the highest `score`, or 0 if no score is positive.
template <typename Score>
int findBestPiece(const Components& p, Score&& score) {
    int best = 0;
    double highest = 0.0;
    for (int n = 1; n <= p.count(); ++n) {
        const double s = score(n);
        if (s > highest) highest = s, best = n;
    }
    return best;
}

// Centre and volume of a piece.
struct PieceMeasure {
    Vec3 middle{0.0};  // x and y relative to the canal, z absolute
    double volume_ml = 0.0;
};

std::vector<PieceMeasure> measurePieces(const OrganScene& s, const Components& p) {
    std::vector<PieceMeasure> out(p.size.size());
    forEachVoxel(s.grid, [&](const Index3& i) {
        const auto n = std::size_t(p.number[i]);
        if (n == 0) return;
        const Vec3 d = s.fromCanal(i);
        out[n].middle += Vec3(d.x, d.y, s.grid.centre(i).z);
    });
    for (std::size_t n = 1; n < out.size(); ++n) {
        out[n].middle /= double(p.size[n]);
        out[n].volume_ml = double(p.size[n]) * voxelVolume_ml(s.grid);
    }
    return out;
}

// --- Spleen ---

constexpr double kSpleenAtWall_m = 0.030;

// How well a place relative to the canal fits the spleen, from 0 to 1.
double plausibleSpleen(double x_m, double y_m) {
    return plausible(-x_m, 0.025, 0.095, 0.190) * plausible(y_m, -0.035, 0.040, 0.150);
}

// The most frequent value of the homogeneous tissue denser than muscle at the left wall. In a fatty liver,
// the spleen is denser than the liver.
double estimateSpleen(const OrganScene& s, const FloatVolume& to_wall) {
    constexpr double kMuscle_hu = 75.0, kAboveLiver_hu = 80.0;  // kidneys are denser
    constexpr int kAround = 2;
    constexpr float kSame_hu = 8.0f;
    const FloatVolume mean = boxMean(s.smooth_hu, kAround);
    HuHistogram h(int(kMuscle_hu), int(std::max(kMuscle_hu, s.parenchyma_hu) + kAboveLiver_hu));
    forEachVoxel(s.grid, [&](const Index3& i) {
        if (!s.free_wide[i] || double(to_wall[i]) > kSpleenAtWall_m ||
            std::fabs(mean[i] - s.smooth_hu[i]) > kSame_hu)
            return;
        const Vec3 d = s.fromCanal(i);
        h.add(s.smooth_hu[i], plausibleSpleen(d.x, d.y));
    });
    return h.mode().value_or(s.parenchyma_hu);
}

// Finds the spleen: homogeneous, at the left wall below the lung.
FoundOrgan findSpleen(const OrganScene& s, const FloatVolume& to_wall, double usual_hu) {
    constexpr double kNarrow_hu = 25.0, kWide_hu = 45.0;  // from its usual value
    constexpr double kCore_m = 0.005, kMinCore_ml = 8.0;
    const Mask core =
        eroded(inRange(s.smooth_hu, s.free_wide, usual_hu - kNarrow_hu, usual_hu + kNarrow_hu), kCore_m);
    const Components p = findComponents(core);
    const std::vector<PieceMeasure> pieces = measurePieces(s, p);
    std::vector<double> near(p.size.size(), 0.0);
    for (std::size_t i = 0; i < core.voxels.size(); ++i)
        if (core.voxels[i] && to_wall.voxels[i] < kSpleenAtWall_m)
            near[std::size_t(p.number.voxels[i])] += voxelVolume_ml(s.grid);
    const int best = findBestPiece(p, [&](int n) {
        const PieceMeasure& m = pieces[std::size_t(n)];
        if (m.volume_ml < kMinCore_ml) return 0.0;
        return near[std::size_t(n)] * plausibleSpleen(m.middle.x, m.middle.y);
    });
    if (best == 0) return notFound("spleen", "no homogeneous organ at the left wall");
    Mask spleen =
        growWithin(componentMask(p, best),
                   inRange(s.edgeHu(), s.free_wide, usual_hu - kWide_hu, usual_hu + kWide_hu), 1.4 * kCore_m);
    spleen = intersect(closed(spleen, 0.003), s.free_wide);
    fillCavities(spleen);
    spleen = intersect(opened(spleen, 0.003), s.free_wide);
    keepLargestComponent(spleen);
    FoundOrgan out{"spleen", spleen, 0.0, ""};
    const bool liver = countVoxels(s.liver) > 0;
    out.confidence = (liver ? 1.0 : 0.6) * (0.4 + 0.5 * plausible(volume_ml(spleen), 30.0, 180.0, 900.0));
    return out;
}

// --- Kidneys ---

// Finds a kidney: brighter than `organs_hu`, beside the spine, thicker than vessels.
FoundOrgan findKidney(const OrganScene& s, bool right, double organs_hu) {
    const std::string name = right ? "right kidney" : "left kidney";
    // Pyramids and noise are closed first, so that they do not divide the core.
    constexpr double kAbove_hu = 32.0, kPyramid_m = 0.002, kMax_hu = 420.0, kVessel_m = 0.005,
                     kEdge_m = 0.0025, kSinus_m = 0.005;
    constexpr double kMinCore_ml = 4.0, kUsual_ml = 150.0, kMax_ml = 450.0, kEdge_hu = 80.0, kPole = 0.1;
    const Mask bright = inRange(s.edgeHu(), s.free_wide, organs_hu + kAbove_hu, kMax_hu);
    const Mask core = eroded(closed(bright, kPyramid_m), kVessel_m);
    const Components p = findComponents(core);
    const std::vector<PieceMeasure> pieces = measurePieces(s, p);
    const auto score = [&](int n) {
        const PieceMeasure& m = pieces[std::size_t(n)];
        const double aside = right ? m.middle.x : -m.middle.x;
        if (m.volume_ml < kMinCore_ml) return 0.0;
        return m.volume_ml * plausible(aside, 0.022, 0.060, 0.120) *
               plausible(m.middle.y, -0.035, 0.030, 0.085);
    };
    const int best = findBestPiece(p, score);
    if (best == 0)
        return notFound(name,
                        "nothing as bright beside the spine; no contrast medium, or not in the section");
    Mask poles(s.grid);  // dark pyramids may separate them; pieces that do not touch in the end are dropped
    for (int n = 1; n <= p.count(); ++n)
        if (score(n) > kPole * score(best)) poles = unite(poles, componentMask(p, n));
    Mask kidney = growWithin(poles, bright, 1.3 * kVessel_m);
    // Blur makes the rim half as bright. Pyramids and sinus are darker than cortex.
    const Mask dense = inRange(s.edgeHu(), s.free_wide, kEdge_hu, kMax_hu);
    kidney = growWithin(kidney, dense, std::max(kEdge_m, s.grid.spacing_m.x));
    kidney = intersect(closed(kidney, kSinus_m), s.free_wide);
    fillCavities(kidney);
    kidney = intersect(opened(kidney, 0.003), s.free_wide);
    keepLargestComponent(kidney);
    FoundOrgan out{name, kidney, 0.0, ""};
    out.confidence = 0.5 + 0.5 * plausible(volume_ml(kidney), 20.0, kUsual_ml, kMax_ml);
    return out;
}

// --- Heart ---

// Voxels between the lungs: in the same slice, some right lung is farther right and some left lung is
// farther left.
Mask betweenLungs(const OrganScene& s) {
    const Grid& g = s.grid;
    Mask out(g);
    parallelFor(processorCount(), g.dims.z, [&](int z) {
        int right_end = -1, left_end = g.dims.x;
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                if (s.lung_right[{x, y, z}]) right_end = std::max(right_end, x);
                if (s.lung_left[{x, y, z}]) left_end = std::min(left_end, x);
            }
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = left_end; x <= right_end; ++x)
                out[{x, y, z}] = s.free[{x, y, z}];
    });
    return out;
}

// Finds the heart: blood between the lungs, in front of the spine, above the diaphragm. Includes the vena
// cava only where it opens into the atrium.
FoundOrgan findHeart(const OrganScene& s, const Mask& cava) {
    constexpr double kBlood_hu = 14.0, kMax_hu = 450.0, kWall_hu = 65.0, kCore_m = 0.006, kReach_m = 0.016,
                     kAtrium_m = 0.008;
    constexpr double kBeforeCanal_m = 0.038, kMinCore_ml = 2.0, kChamber = 0.1;
    if (countVoxels(s.lung_right) == 0 || countVoxels(s.lung_left) == 0)
        return notFound("heart", "one lung is not in the section, so nothing lies between the two");
    Mask chest = betweenLungs(s);
    forEachVoxel(s.grid, [&](const Index3& i) {
        if (chest[i] && s.fromCanal(i).y < kBeforeCanal_m) chest[i] = 0;
    });
    const Mask blood = inRange(s.edgeHu(), chest, s.parenchyma_hu + kBlood_hu, kMax_hu);
    const Mask core = eroded(subtract(closed(blood, 0.004), cava), kCore_m);
    const Components p = findComponents(core);
    const std::vector<PieceMeasure> pieces = measurePieces(s, p);
    const double top_m = s.grid.centre(s.grid.dims - 1).z;
    const auto score = [&](int n) {
        const PieceMeasure& m = pieces[std::size_t(n)];
        if (m.volume_ml < kMinCore_ml) return 0.0;
        return m.volume_ml * plausible(m.middle.x, -0.110, -0.025, 0.060) *
               plausible(m.middle.y, 0.040, 0.100, 0.220) * (1.0 - std::min(1.0, (top_m - m.middle.z) / 0.5));
    };
    const int best = findBestPiece(p, score);
    if (best == 0) return notFound("heart", "no large pool of contrast medium between the lungs");
    Mask found(s.grid);  // the chambers may be separate
    for (int n = 1; n <= p.count(); ++n)
        if (score(n) > kChamber * score(best)) found = unite(found, componentMask(p, n));
    chest = subtract(chest, subtract(cava, dilated(found, kAtrium_m)));
    Mask heart = growWithin(found, inRange(s.edgeHu(), chest, kWall_hu, kMax_hu), kReach_m);
    heart = intersect(closed(heart, 0.006), chest);
    fillCavities(heart);
    heart = intersect(opened(heart, 0.004), chest);
    keepLargestComponent(heart);
    FoundOrgan out{"heart", heart, 0.0, ""};
    const bool liver = countVoxels(s.liver) > 0;
    out.confidence = (liver ? 1.0 : 0.5) * (0.5 + 0.3 * plausible(volume_ml(heart), 20.0, 350.0, 1200.0));
    if (!liver) out.note = "heart: its lower side is uncertain without the liver";
    return out;
}

// --- Gallbladder ---

// Finds the gallbladder: a dark homogeneous pouch at the liver's lower side.
FoundOrgan findGallbladder(const OrganScene& s) {
    constexpr double kLow_hu = -15.0, kHigh_hu = 38.0, kCore_m = 0.0035, kRim_hu = 62.0, kContact_m = 0.006;
    if (countVoxels(s.liver) == 0)
        return notFound("gallbladder", "it is looked for at the liver, which is not known");
    const Mask dark = eroded(inRange(s.smooth_hu, s.free, kLow_hu, kHigh_hu), kCore_m);
    // The liver surrounds a necrotic tumour, which is as dark.
    const Mask core = subtract(dark, surroundedPieces(dark, s.liver));
    const Components p = findComponents(core);
    const std::vector<PieceMeasure> pieces = measurePieces(s, p);
    const Mask at_liver = dilated(s.liver, kContact_m + kCore_m), at_gas = dilated(s.gas, 0.008);
    std::vector<double> touch(p.size.size(), 0.0), gas = touch;
    for (std::size_t i = 0; i < core.voxels.size(); ++i) {
        const auto n = std::size_t(p.number.voxels[i]);
        if (n == 0) continue;
        touch[n] += at_liver.voxels[i];
        gas[n] += at_gas.voxels[i];
    }
    const auto contact = [&](int n) { return touch[std::size_t(n)] / double(p.size[std::size_t(n)]); };
    const int best = findBestPiece(p, [&](int n) {
        const PieceMeasure& m = pieces[std::size_t(n)];
        if (m.volume_ml < 0.7 || m.volume_ml > 120.0 || m.middle.x < -0.01) return 0.0;
        if (m.middle.y < 0.03) return 0.0;  // fluid beside the spine belongs to a kidney
        const double share = contact(n), airy = gas[std::size_t(n)] / double(p.size[std::size_t(n)]);
        return share < 0.15 || airy > 0.2 ? 0.0 : std::min(m.volume_ml, 20.0) * share;
    });
    if (best == 0)
        return notFound("gallbladder", "no dark pouch at the liver; removed, empty, or not in the section");
    Mask bladder = growWithin(componentMask(p, best), inRange(s.edgeHu(), s.free, kLow_hu - 10.0, kRim_hu),
                              1.5 * kCore_m);
    bladder = intersect(closed(bladder, 0.003), s.free);
    bladder = opened(bladder, 0.0025);
    keepLargestComponent(bladder);
    FoundOrgan out{"gallbladder", bladder, 0.0, ""};
    out.confidence =
        0.3 + 0.4 * std::min(1.0, 2.0 * contact(best)) * plausible(volume_ml(bladder), 2.0, 30.0, 150.0);
    return out;
}

double leftDomeHeight(const OrganInput& in) {
    double top = -1e9;
    for (const float z : in.lungs.base_left.z_m)
        if (std::isfinite(z)) top = std::max(top, double(z));
    return top > -1e8 ? top : in.ct.grid.centre(in.ct.grid.dims - 1).z;
}

}  // namespace

OrganScene makeScene(const OrganInput& in, const VoxelBox& box, const Mask& beside) {
    const auto part = [&](const Mask& whole) { return cropped(whole, box); };
    CtVolume ct = cropped(in.ct, box);
    const Grid g = ct.grid;
    OrganScene s{.ct = std::move(ct),
                 .grid = g,
                 .inside = part(in.inside),
                 .liver = part(in.liver),
                 .portal = part(in.portal),
                 .lung_right = part(in.lungs.right),
                 .lung_left = part(in.lungs.left),
                 .gas = part(in.lungs.gas),
                 .left_dome_m = leftDomeHeight(in)};
    FloatVolume hu = toFloat(s.ct);
    s.smooth_hu = boxMean(hu, 1);
    if (g.spacing_m.x >= 0.0015) s.unsmoothed_hu = std::move(hu);
    const VoxelBox body = boundingBox(in.body);
    const Vec3 low = in.body.grid.centre(body.low), high = in.body.grid.centre(body.high);
    s.canal.assign(std::size_t(g.dims.z), Vec3(0.5 * (low.x + high.x), low.y + 0.06, 0.0));
    for (int z = 0; z < g.dims.z && !in.bones.canal_m.empty(); ++z) {
        const double height_m = g.centre({0, 0, z}).z;
        s.canal[std::size_t(z)] = *std::min_element(
            in.bones.canal_m.begin(), in.bones.canal_m.end(), [&](const Vec3& a, const Vec3& b) {
                return std::fabs(a.z - height_m) < std::fabs(b.z - height_m);
            });
    }
    // More noise would tear holes into organs with a narrow range: it is 5 HU in a usual scan, and 14 HU with
    // noise x3. Larger voxels are averaged enough.
    constexpr double kMaxNoise_hu = 11.0;
    if (s.unsmoothed_hu.voxels.empty() && measureNoise_hu(s.smooth_hu, s.liver) > kMaxNoise_hu)
        s.smooth_hu = boxMean(s.smooth_hu, 1);
    s.parenchyma_hu = estimateParenchyma(s, part(in.bones.all));
    s.free = s.free_wide = Mask(g);
    forEachVoxel(g, [&](const Index3& i) {
        const Index3 at = box.low + i;
        const bool known = in.bones.all[at] || in.bones.canal[at] || in.bones.cartilage[at] ||
                           in.lungs.right[at] || in.lungs.left[at] || in.lungs.airways[at] || in.liver[at];
        s.free[i] = in.inside[at] && in.body[at] && !known;
        s.free_wide[i] = (s.free[i] || beside[at]) && !known;
    });
    return s;
}

Mask inRange(const FloatVolume& hu, const Mask& within, double low_hu, double high_hu) {
    return maskWhere(hu.grid, [&](std::size_t i) {
        return within.voxels[i] && double(hu.voxels[i]) >= low_hu && double(hu.voxels[i]) <= high_hu;
    });
}

Mask growWithin(const Mask& core, const Mask& passable, double reach_m) {
    const int steps = std::max(1, int(std::lround(1.25 * reach_m / core.grid.spacing_m.x)));
    return intersect(growSeeds(core, passable, steps), dilated(core, reach_m));
}

std::vector<FoundOrgan> findOrgans(const OrganInput& in) {
    constexpr double kBesideFascia_m = 0.020;  // behind kidney and spleen the fascia is uncertain
    constexpr double kRim_m = 0.012;           // thickness of skin and its fat
    constexpr double kMargin_m = 0.004;        // for means over neighbours
    constexpr int kMinMargin = 4;              // voxels
    // Of what is found between 0.06 and 0.12 m, 53 % was portal vein in a real patient and 78 % in a
    // reference one, before renal veins were found. Most of the rest is arteries and cava that were not found
    // before.
    constexpr double kPortalLength_m = 0.120;
    Mask beside = intersect(dilated(in.inside, kBesideFascia_m), eroded(in.body, kRim_m));
    const int margin = std::max(kMinMargin, int(std::ceil(kMargin_m / in.ct.grid.spacing_m.x)));
    VoxelBox box = boxAround(unite(beside, in.inside), margin);
    if (box.empty()) box = {Index3(0), in.ct.grid.dims - 1};
    OrganScene s = makeScene(in, box, beside);
    beside = {};
    FloatVolume to_wall = distanceTo(inverted(s.inside));
    const double spleen_hu = estimateSpleen(s, to_wall), densest_hu = std::max(s.parenchyma_hu, spleen_hu);
    std::vector<FoundOrgan> out;
    const auto removeFromFree = [&](const Mask& taken) {
        s.free = subtract(s.free, taken);
        s.free_wide = subtract(s.free_wide, taken);
    };
    const auto addOrgan = [&](FoundOrgan organ) {
        if (organ.mask.voxels.empty()) organ.mask = Mask(s.grid);
        removeFromFree(organ.mask);
        out.push_back(std::move(organ));
    };
    // Find the vessels first, so that no organ grows into them. Voxels that a kidney encloses belong to the
    // kidney.
    auto [aorta, cava] = findGreatVessels(s);
    removeFromFree(aorta.mask);
    for (const bool right : {true, false}) {
        FoundOrgan kidney = findKidney(s, right, densest_hu);
        // The spleen's value may be that of medium in the bowel.
        if (kidney.mask.voxels.empty() && densest_hu > s.parenchyma_hu)
            kidney = findKidney(s, right, s.parenchyma_hu);
        addOrgan(std::move(kidney));
    }
    addOrgan(findSpleen(s, to_wall, spleen_hu));
    to_wall = {};  // the hollow organs need the memory
    addOrgan(findHeart(s, cava.mask));
    for (const FoundOrgan& organ : out)
        cava.mask = subtract(cava.mask, organ.mask);
    addOrgan(std::move(aorta));
    removeFromFree(cava.mask);
    const Mask &kidney_right = out[0].mask, &kidney_left = out[1].mask;
    cava.mask = unite(cava.mask, findRenalVeins(s, kidney_right, kidney_left, cava.mask));
    addOrgan(std::move(cava));
    addOrgan(findExtrahepaticPortalVein(s, kPortalLength_m));
    s.portal = {};  // the hollow organs need the memory
    addOrgan(findGallbladder(s));
    for (FoundOrgan& organ :
         findHollowOrgans(s, std::max(s.parenchyma_hu, std::min(spleen_hu, kUsualOrgan_hu))))
        addOrgan(std::move(organ));
    for (FoundOrgan& organ : out) {
        Mask whole(in.ct.grid);
        paste(organ.mask, box.low, whole);
        organ.mask = std::move(whole);
    }
    return out;
}

}  // namespace stylet::modeller
