#include "app/modeller/segmentation/liver_border.h"

#include <algorithm>
#include <cmath>

#include "app/modeller/image/vector_field.h"
#include "app/modeller/segmentation/graph_cut.h"
#include "app/modeller/segmentation/morphology.h"

namespace stylet::modeller {

namespace {

// Second cut: cost of separating two similar voxels, and the preference for the border of the first cut.
constexpr float kFineLink = 0.7f, kStay = 0.4f;
// Tissue is measured at distances from kClear_m to kBeside_m from the border. Closer to it, tissue is
// blurred.
constexpr float kClear_m = 0.003f, kBeside_m = 0.010f;
// Tissue beyond the border must differ from liver by at least kContrast_hu. Values are clamped: tissue darker
// than fat counts as fat, and lung counts as diaphragm. Between liver and lung lies the diaphragm, two or
// three millimetres of muscle that the lung's blur darkens.
constexpr float kContrast_hu = 25.0f, kMinDark_hu = -100.0f, kLungBelow_hu = -300.0f, kDiaphragm_hu = 20.0f;
constexpr double kNoisyVoxel_m = 0.0015;  // finer voxels are too noisy individually
constexpr float kMinFineLink = 0.1f;
constexpr double kVesselGap_m = 0.004;  // half the width of the widest vessel that closeLiver() closes
// Tissue that deviates more is tumour or vessel. It does not represent the liver beside the border.
constexpr float kMaxDeviation_hu = 70.0f;
constexpr float kMaxBright_hu = 220.0f;  // bone is as bright as a kidney

// Local mean of the CT values of the added voxels.
class LocalMean {
  public:
    explicit LocalMean(const Grid& g) : sum_(g), count_(g) {}
    void add(std::size_t i, float hu) { sum_.voxels[i] = hu, count_.voxels[i] = 1.0f; }
    void finish(int reach) { sum_ = boxMean(sum_, reach), count_ = boxMean(count_, reach); }
    float at(std::size_t i, float fallback) const {
        return count_.voxels[i] > kMinShare ? sum_.voxels[i] / count_.voxels[i] : fallback;
    }

  private:
    static constexpr float kMinShare = 0.005f;  // share of the box
    FloatVolume sum_, count_;
};

// Returns the value that represents a dark voxel beyond the border. For lung, this is the value of the
// diaphragm, which lies between liver and lung.
float clampDark(float hu) {
    return hu < kLungBelow_hu ? kDiaphragm_hu : std::max(kMinDark_hu, hu);
}

// Computes the evidence of voxels at the border: 1 liver, -1 not liver. The voxel is compared with the local
// mean of the liver and the local means of darker and of brighter tissue beyond the border. Both comparisons
// must indicate liver.
FloatVolume borderEvidence(const FloatVolume& hu, const FloatVolume& depth, const Mask& open,
                           const Parenchyma& liver) {
    const Grid& g = hu.grid;
    LocalMean inside(g), darker(g), brighter(g);
    for (std::size_t i = 0; i < hu.voxels.size(); ++i) {
        const float d = hu.voxels[i] - liver.mean_hu;
        if (depth.voxels[i] > kClear_m && depth.voxels[i] < kBeside_m) {
            if (std::abs(d) < kMaxDeviation_hu) inside.add(i, hu.voxels[i]);
        } else if (-depth.voxels[i] > kClear_m && -depth.voxels[i] < kBeside_m) {
            if (d < -kContrast_hu) darker.add(i, clampDark(hu.voxels[i]));
            if (d > kContrast_hu && open.voxels[i]) brighter.add(i, std::min(kMaxBright_hu, hu.voxels[i]));
        }
    }
    const int reach = std::max(1, int(std::lround(double(kBeside_m) / g.spacing_m.x)));
    for (LocalMean* mean : {&inside, &darker, &brighter})
        mean->finish(reach);
    FloatVolume evidence(g);
    parallelVoxels(g, [&](const Index3& at) {
        const std::size_t i = g.offset(at);
        const float in = inside.at(i, liver.mean_hu);
        const float to_dark = std::max(kContrast_hu, in - darker.at(i, in - 2.0f * kContrast_hu));
        const float to_bright = std::max(kContrast_hu, brighter.at(i, in + 2.0f * kContrast_hu) - in);
        const float d = hu.voxels[i] - in;
        evidence.voxels[i] = std::clamp(1.0f + 2.0f * std::min(d / to_dark, -d / to_bright), -1.0f, 1.0f);
    });
    return evidence;
}

// Moves the border of `first` by at most the band, on the CT's own voxels.
Mask fineCut(const FloatVolume& hu, const Mask& open, const Mask& first, const Parenchyma& liver,
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
        return kFineLink * std::max(kMinFineLink, std::exp(-0.5f * d * d));
    };
    return minimumCut(problem);
}

}  // namespace

void closeLiver(Mask& liver, const Mask& open) {
    liver = unite(intersect(closed(liver, kVesselGap_m), open), liver);
    fillCavities(liver);
}

Mask refineLiver(const CtVolume& ct, const Mask& open, const Mask& first, const Parenchyma& liver,
                 double band_m) {
    const VoxelBox box = boundingBox(first);
    const Vec3 margin(band_m + double(kBeside_m));
    const Index3 last = ct.grid.dims - 1;
    const Index3 low = glm::clamp(ct.grid.nearest(first.grid.centre(box.low) - margin), Index3(0), last);
    const Index3 high = glm::clamp(ct.grid.nearest(first.grid.centre(box.high) + margin), Index3(0), last);
    FloatVolume hu({high - low + 1, ct.grid.spacing_m, ct.grid.centre(low)});
    Mask open_here(hu.grid), start(hu.grid);
    const FloatVolume smooth = toFloat(first);
    parallelVoxels(hu.grid, [&](const Index3& i) {
        hu[i] = float(ct[low + i]);
        open_here[i] = open[low + i];
        start[i] = valueAt(smooth, hu.grid.centre(i), 0.0f) > 0.5f;
    });
    if (hu.grid.spacing_m.x < kNoisyVoxel_m) hu = boxMean(hu, 1);
    Mask cut = fineCut(hu, open_here, start, liver, float(band_m));
    closeLiver(cut, open_here);
    keepLargestComponent(cut);
    Mask out(ct.grid);
    parallelVoxels(hu.grid, [&](const Index3& i) { out[low + i] = cut[i]; });
    return out;
}

}  // namespace stylet::modeller
