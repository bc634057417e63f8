#include "app/modeller/segmentation/liver_border.h"

#include <algorithm>
#include <cmath>

#include "app/modeller/image/vector_field.h"
#include "app/modeller/segmentation/graph_cut.h"
#include "app/modeller/segmentation/morphology.h"

namespace stylet::modeller {

namespace {

// Second cut: cost of separating two similar voxels, and the pull towards the first cut's border.
constexpr float kFineLink = 0.7f, kStay = 0.4f;
// Tissue counts as next to the border from outside its blur to this depth.
constexpr float kClear_m = 0.003f, kBeside_m = 0.010f;
// Neighbours must differ from liver by at least this much. Values are clamped: nothing counts as darker
// than fat, and next to lung lies the diaphragm, two or three millimetres of muscle that the lung's blur
// darkens.
constexpr float kContrast_hu = 25.0f, kDarkest_hu = -100.0f, kLungBelow_hu = -300.0f, kDiaphragm_hu = 20.0f;
constexpr double kNoisyVoxel_m = 0.0015;  // finer voxels are too noisy individually
constexpr float kLeastFineLink = 0.1f;
constexpr double kVesselGap_m = 0.004;  // half the width of the widest vessel that is closed
// Tumours and vessels do not represent the liver beside the border.
constexpr float kOdd_hu = 70.0f;
constexpr float kBrightest_hu = 220.0f;  // bone is as bright as a kidney

template <typename Visit>
void forEachIn(const Grid& g, const Visit& visit) {
    forEachSlab(g.dims.z, [&](int z) {
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x)
                visit(Index3{x, y, z});
    });
}

// Local mean of the CT values of the added voxels.
class LocalMean {
  public:
    explicit LocalMean(const Grid& g) : sum_(g), count_(g) {}
    void add(std::size_t i, float hu) { sum_.voxels[i] = hu, count_.voxels[i] = 1.0f; }
    void finish(int reach) { sum_ = boxMean(sum_, reach), count_ = boxMean(count_, reach); }
    float at(std::size_t i, float otherwise) const {
        return count_.voxels[i] > kFewest ? sum_.voxels[i] / count_.voxels[i] : otherwise;
    }

  private:
    static constexpr float kFewest = 0.005f;  // share of the box
    FloatVolume sum_, count_;
};

// Next to lung, uses the value of the diaphragm, which lies between liver and lung.
float darknessOf(float hu) {
    return hu < kLungBelow_hu ? kDiaphragm_hu : std::max(kDarkest_hu, hu);
}

// Evidence of voxels at the border: 1 liver, -1 not liver. The voxel is compared with the liver's local
// mean and the local mean of darker tissue beyond the border, and likewise with brighter tissue. Both must
// agree.
FloatVolume borderEvidence(const FloatVolume& hu, const FloatVolume& depth, const Mask& open,
                           const Parenchyma& liver) {
    const Grid& g = hu.grid;
    LocalMean inside(g), darker(g), brighter(g);
    for (std::size_t i = 0; i < hu.voxels.size(); ++i) {
        const float d = hu.voxels[i] - liver.mean_hu;
        if (depth.voxels[i] > kClear_m && depth.voxels[i] < kBeside_m) {
            if (std::abs(d) < kOdd_hu) inside.add(i, hu.voxels[i]);
        } else if (-depth.voxels[i] > kClear_m && -depth.voxels[i] < kBeside_m) {
            if (d < -kContrast_hu) darker.add(i, darknessOf(hu.voxels[i]));
            if (d > kContrast_hu && open.voxels[i]) brighter.add(i, std::min(kBrightest_hu, hu.voxels[i]));
        }
    }
    const int reach = std::max(1, int(std::lround(double(kBeside_m) / g.spacing_m.x)));
    for (LocalMean* mean : {&inside, &darker, &brighter})
        mean->finish(reach);
    FloatVolume evidence(g);
    forEachSlab(g.dims.z, [&](int z) {
        const std::size_t begin = g.offset({0, 0, z}), end = begin + g.offset({0, 0, 1});
        for (std::size_t i = begin; i < end; ++i) {
            const float in = inside.at(i, liver.mean_hu);
            const float to_dark = std::max(kContrast_hu, in - darker.at(i, in - 2.0f * kContrast_hu));
            const float to_bright = std::max(kContrast_hu, brighter.at(i, in + 2.0f * kContrast_hu) - in);
            const float d = hu.voxels[i] - in;
            evidence.voxels[i] = std::clamp(1.0f + 2.0f * std::min(d / to_dark, -d / to_bright), -1.0f, 1.0f);
        }
    });
    return evidence;
}

// Moves the border of `first` by at most the band, on the CT's own voxels.
Mask secondCut(const FloatVolume& hu, const Mask& open, const Mask& first, const Parenchyma& liver,
               float band_m) {
    const Grid& g = hu.grid;
    FloatVolume depth = distanceTo(inverted(first));
    {
        const FloatVolume out = distanceTo(first);
        for (std::size_t i = 0; i < depth.voxels.size(); ++i)
            depth.voxels[i] -= out.voxels[i];
    }
    CutProblem problem;
    problem.preference = borderEvidence(hu, depth, open, liver);
    problem.state = Mask(g);
    for (std::size_t i = 0; i < depth.voxels.size(); ++i) {
        const float d = depth.voxels[i];
        problem.state.voxels[i] = std::uint8_t(d > band_m                       ? CutState::object
                                               : d < -band_m || !open.voxels[i] ? CutState::background
                                                                                : CutState::free);
        problem.preference.voxels[i] += kStay * std::clamp(d / band_m, -1.0f, 1.0f);
    }
    const float edge_hu = 3.0f * liver.sigma_hu;
    problem.link = [&](std::size_t i, std::size_t k) {
        const float d = (hu.voxels[i] - hu.voxels[k]) / edge_hu;
        return kFineLink * std::max(kLeastFineLink, std::exp(-0.5f * d * d));
    };
    return minimumCut(problem);
}

}  // namespace

void closeLiver(Mask& liver, const Mask& open) {
    liver = either(both(closed(liver, kVesselGap_m), open), liver);
    fillCavities(liver);
}

Mask refineLiver(const CtVolume& ct, const Mask& open, const Mask& first, const Parenchyma& liver,
                 double band_m) {
    const VoxelBox box = boxOf(first);
    const Vec3 margin(band_m + double(kBeside_m));
    const Index3 last = ct.grid.dims - 1;
    const Index3 low = glm::clamp(ct.grid.nearest(first.grid.centre(box.low) - margin), Index3(0), last);
    const Index3 high = glm::clamp(ct.grid.nearest(first.grid.centre(box.high) + margin), Index3(0), last);
    FloatVolume hu({high - low + 1, ct.grid.spacing_m, ct.grid.centre(low)});
    Mask open_here(hu.grid), start(hu.grid);
    FloatVolume smooth(first.grid);
    std::copy(first.voxels.begin(), first.voxels.end(), smooth.voxels.begin());
    forEachIn(hu.grid, [&](const Index3& i) {
        hu[i] = float(ct[low + i]);
        open_here[i] = open[low + i];
        start[i] = valueAt(smooth, hu.grid.centre(i), 0.0f) > 0.5f;
    });
    if (hu.grid.spacing_m.x < kNoisyVoxel_m) hu = boxMean(hu, 1);
    Mask cut = secondCut(hu, open_here, start, liver, float(band_m));
    closeLiver(cut, open_here);
    keepLargest(cut);
    Mask out(ct.grid);
    forEachIn(hu.grid, [&](const Index3& i) { out[low + i] = cut[i]; });
    return out;
}

}  // namespace stylet::modeller
