#include "app/modeller/import/tissue_classes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/import/import_map.h"

namespace stylet::modeller {

using patient::Tissue;

namespace {

// Distance between the mean of a tissue and a threshold, in standard deviations of the tissue's noise. With a
// smaller distance, noise would turn muscle voxels under the needle into bone, and fat voxels into skin. At
// 5.5, this happens to one voxel in fifty million.
constexpr double kNoiseSigmas = 5.5;
// The possible range of each class in a calibrated CT, HU.
constexpr double kFat[] = {-200.0, -30.0}, kSoft[] = {0.0, 130.0}, kBone[] = {180.0, 3000.0};
constexpr double kLabelledBone[] = {150.0, 3000.0}, kLabelledBlood[] = {0.0, 600.0};
// Depth of the body wall. It contains skin, fat, muscle and ribs, but hardly any vessel or organ.
constexpr float kWall_m = 0.035f;
// Limits for tissue with contrast medium. It is brighter than the wall's muscle by at least kBrighter_hu, not
// brighter than kBrightest_hu, and thick. Its roughness is at most kMaxRoughness times the noise. The inside
// of bone is rougher.
constexpr double kBrighter_hu = 60.0, kBrightest_hu = 450.0, kMaxRoughness = 1.3;
constexpr float kThick_m = 0.003f;
constexpr int kReach = 2;  // half the side, in voxels, of the cube in which roughness is measured
constexpr double kMinBloodShare = 1e-4;

class Histogram {
  public:
    static constexpr int kLowest = -1024, kBins = 4096;
    void add(int hu) {
        counts_[std::size_t(std::clamp(hu - kLowest, 0, kBins - 1))] += 1.0;
        total_ += 1.0;
    }
    // Mean and spread around the range's peak: first over the whole range, then within two sigma of the
    // last result, so that the tails of neighbouring classes do not widen it.
    TissueClass fitNormal(const double (&range)[2]) const {
        TissueClass c = moments(range[0], range[1]);
        for (int i = 0; i < 3; ++i)
            c = moments(std::max(range[0], c.mean_hu - 2.0 * c.sigma_hu),
                        std::min(range[1], c.mean_hu + 2.0 * c.sigma_hu));
        c.sigma_hu *= 1.137;  // corrects for cutting a normal distribution at two sigma
        return c;
    }

  private:
    TissueClass moments(double low, double high) const {
        TissueClass c{0.5 * (low + high), 1.0, 0.0};
        double count = 0.0, sum = 0.0, squares = 0.0;
        for (int b = 0; b < kBins; ++b) {
            const double hu = b + kLowest, n = counts_[std::size_t(b)];
            if (hu < low || hu > high) continue;
            count += n, sum += n * hu, squares += n * hu * hu;
        }
        if (count == 0.0) return c;
        c.mean_hu = sum / count;
        c.sigma_hu = std::max(1.0, std::sqrt(std::max(0.0, squares / count - c.mean_hu * c.mean_hu)));
        c.share = count / total_;
        return c;
    }
    std::array<double, kBins> counts_{};
    double total_ = 0.0;
};

// The value between the means where two equally weighted normal distributions cross: the Bayes border.
double equalLikelihood(const TissueClass& a, const TissueClass& b) {
    double low = a.mean_hu, high = b.mean_hu;
    const auto likelier_b = [&](double x) {
        const double za = (x - a.mean_hu) / a.sigma_hu, zb = (x - b.mean_hu) / b.sigma_hu;
        return -0.5 * zb * zb - std::log(b.sigma_hu) > -0.5 * za * za - std::log(a.sigma_hu);
    };
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (likelier_b(middle) ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

// Standard deviation in a cube around each voxel.
FloatVolume roughness(const CtVolume& ct) {
    FloatVolume value(ct.grid), square(ct.grid);
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        value.voxels[i] = float(ct.voxels[i]);
        square.voxels[i] = float(ct.voxels[i]) * float(ct.voxels[i]);
    }
    const FloatVolume mean = boxMean(value, kReach);
    FloatVolume rough = boxMean(square, kReach);
    for (std::size_t i = 0; i < rough.voxels.size(); ++i)
        rough.voxels[i] = std::sqrt(std::max(0.0f, rough.voxels[i] - mean.voxels[i] * mean.voxels[i]));
    return rough;
}

// Estimates the noise of homogeneous tissue as the peak of the roughness histogram, without fat, air and
// bone.
double estimateNoise(const CtVolume& ct, const Mask& body, const FloatVolume& rough, const TissueClass& fat) {
    std::array<double, 100> counts{};  // bins of half a HU
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        if (body.voxels[i] && ct.voxels[i] > fat.mean_hu + 60.0 && ct.voxels[i] < 250 &&
            rough.voxels[i] < 50.0f)
            counts[std::size_t(2.0f * rough.voxels[i])] += 1.0;
    const auto peak = std::max_element(counts.begin(), counts.end());
    return std::max(1.0, 0.5 * (double(peak - counts.begin()) + 0.5));
}

TissueClass estimateBlood(const CtVolume& ct, const Mask& body, const FloatVolume& depth,
                          const FloatVolume& rough, const TissueClass& soft, double noise_hu) {
    const Mask other = maskWhere(ct.grid, [&](std::size_t i) {
        return ct.voxels[i] < soft.mean_hu + kBrighter_hu || ct.voxels[i] > kBrightest_hu;
    });
    const FloatVolume thickness = distanceTo(other);
    Histogram blood;
    double voxels = 0.0, found = 0.0;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        if (!body.voxels[i]) continue;
        voxels += 1.0;
        if (depth.voxels[i] < kWall_m || thickness.voxels[i] < kThick_m) continue;
        if (double(rough.voxels[i]) > kMaxRoughness * noise_hu) continue;
        found += 1.0;
        blood.add(ct.voxels[i]);
    }
    if (found < kMinBloodShare * voxels) return {};
    const double range[] = {soft.mean_hu + kBrighter_hu, kBrightest_hu};
    TissueClass out = blood.fitNormal(range);
    out.share = found / voxels;
    return out;
}

}  // namespace

TissueClasses estimateTissueClasses(const CtVolume& ct, const Mask& body) {
    const FloatVolume depth = distanceTo(inverted(body));
    Histogram all, wall;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        if (!body.voxels[i]) continue;
        all.add(ct.voxels[i]);
        if (depth.voxels[i] < kWall_m) wall.add(ct.voxels[i]);
    }
    TissueClasses c;
    c.fat = all.fitNormal(kFat);
    c.soft = wall.fitNormal(kSoft);
    c.bone = wall.fitNormal(kBone);
    const FloatVolume rough = roughness(ct);
    c.blood = estimateBlood(ct, body, depth, rough, c.soft, estimateNoise(ct, body, rough, c.fat));
    return c;
}

TissueClasses estimateTissueClasses(const CtVolume& ct, const Mask& body, const LabelVolume& labels) {
    std::array<Tissue, 256> tissue{};
    for (const patient::Label& l : targetTable())
        tissue[l.id] = l.tissue;
    Histogram open, bone, blood;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        if (!body.voxels[i]) continue;
        if (labels.voxels[i] == 0)
            open.add(ct.voxels[i]);
        else if (isSkeleton(tissue[labels.voxels[i]]))
            bone.add(ct.voxels[i]);
        else if (tissue[labels.voxels[i]] == Tissue::vessel)
            blood.add(ct.voxels[i]);
    }
    return {open.fitNormal(kFat), open.fitNormal(kSoft), blood.fitNormal(kLabelledBlood),
            bone.fitNormal(kLabelledBone)};
}

patient::Thresholds computeThresholds(const TissueClasses& c) {
    patient::Thresholds t;
    // Skin thresholds: the body's rim is a mixture of air and fat, from half air to where fat begins.
    t.t1_hu = std::round(c.fat.mean_hu - kNoiseSigmas * c.fat.sigma_hu);
    t.t0_hu = std::round(std::min(0.5 * (-1000.0 + c.fat.mean_hu), t.t1_hu - 50.0));
    t.t2_sensitive_hu = std::round(c.soft.mean_hu + kNoiseSigmas * c.soft.sigma_hu);
    if (c.bone.share > 0.0)
        t.t2_sensitive_hu = std::max(t.t2_sensitive_hu, std::round(equalLikelihood(c.soft, c.bone)));
    t.t2_specific_hu = t.t2_sensitive_hu;
    if (c.blood.share > 0.0)
        t.t2_specific_hu = std::max(t.t2_specific_hu, std::round(c.blood.mean_hu + 4.0 * c.blood.sigma_hu));
    return t;
}

}  // namespace stylet::modeller
