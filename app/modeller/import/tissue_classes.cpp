#include "app/modeller/import/tissue_classes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/import/import_map.h"

namespace stylet::modeller {

using patient::Tissue;

namespace {

// Noise must not turn a muscle voxel into bone, or a fat voxel into skin, under the needle. 5.5 sigma is
// one voxel in fifty million.
constexpr double kNoNoise = 5.5;
// The possible range of each class in a calibrated CT, HU.
constexpr double kFat[] = {-200.0, -30.0}, kSoft[] = {0.0, 130.0}, kBone[] = {180.0, 3000.0};
constexpr double kLabelledBone[] = {150.0, 3000.0}, kLabelledBlood[] = {0.0, 600.0};
// The body wall: skin, fat, muscle and ribs, but hardly any vessel or organ.
constexpr float kWall_m = 0.035f;
// Tissue with contrast medium is this much brighter than the wall's muscle, and thick. The inside of bone
// is rougher than noise.
constexpr double kBrighter_hu = 60.0, kBrightest_hu = 450.0, kRough = 1.3;
constexpr float kThick_m = 0.003f;
constexpr int kReach = 2;  // half the side, in voxels, of the cube in which roughness is measured
constexpr double kFewest = 1e-4;

class Histogram {
  public:
    static constexpr int kLowest = -1024, kBins = 4096;
    void add(int hu) {
        counts_[std::size_t(std::clamp(hu - kLowest, 0, kBins - 1))] += 1.0;
        total_ += 1.0;
    }
    // Mean and spread around the range's peak: first over the whole range, then within two sigma of the
    // last result, so that the tails of neighbouring classes do not widen it.
    TissueClass between(const double (&range)[2]) const {
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
double border(const TissueClass& a, const TissueClass& b) {
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

// The noise of homogeneous tissue: the roughness histogram's peak, without fat, air and bone.
double noiseOf(const CtVolume& ct, const Mask& body, const FloatVolume& rough, const TissueClass& fat) {
    std::array<double, 100> counts{};  // bins of half a HU
    for (std::size_t i = 0; i < ct.voxels.size(); ++i)
        if (body.voxels[i] && ct.voxels[i] > fat.mean_hu + 60.0 && ct.voxels[i] < 250 &&
            rough.voxels[i] < 50.0f)
            counts[std::size_t(2.0f * rough.voxels[i])] += 1.0;
    const auto peak = std::max_element(counts.begin(), counts.end());
    return std::max(1.0, 0.5 * (double(peak - counts.begin()) + 0.5));
}

TissueClass bloodOf(const CtVolume& ct, const Mask& body, const FloatVolume& depth, const FloatVolume& rough,
                    const TissueClass& soft, double noise_hu) {
    Mask other(ct.grid);
    for (std::size_t i = 0; i < other.voxels.size(); ++i)
        other.voxels[i] = ct.voxels[i] < soft.mean_hu + kBrighter_hu || ct.voxels[i] > kBrightest_hu;
    const FloatVolume thickness = distanceTo(other);
    Histogram blood;
    double voxels = 0.0, found = 0.0;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        if (!body.voxels[i]) continue;
        voxels += 1.0;
        if (depth.voxels[i] < kWall_m || thickness.voxels[i] < kThick_m) continue;
        if (double(rough.voxels[i]) > kRough * noise_hu) continue;
        found += 1.0;
        blood.add(ct.voxels[i]);
    }
    if (found < kFewest * voxels) return {};
    const double range[] = {soft.mean_hu + kBrighter_hu, kBrightest_hu};
    TissueClass out = blood.between(range);
    out.share = found / voxels;
    return out;
}

}  // namespace

TissueClasses classesOf(const CtVolume& ct, const Mask& body) {
    const FloatVolume depth = distanceTo(inverted(body));
    Histogram all, wall;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        if (!body.voxels[i]) continue;
        all.add(ct.voxels[i]);
        if (depth.voxels[i] < kWall_m) wall.add(ct.voxels[i]);
    }
    TissueClasses c;
    c.fat = all.between(kFat);
    c.soft = wall.between(kSoft);
    c.bone = wall.between(kBone);
    const FloatVolume rough = roughness(ct);
    c.blood = bloodOf(ct, body, depth, rough, c.soft, noiseOf(ct, body, rough, c.fat));
    return c;
}

TissueClasses classesOf(const CtVolume& ct, const Mask& body, const LabelVolume& labels) {
    std::array<Tissue, 256> tissue{};
    for (const patient::Label& l : targetTable())
        tissue[l.id] = l.tissue;
    Histogram open, bone, blood;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        if (!body.voxels[i]) continue;
        if (labels.voxels[i] == 0)
            open.add(ct.voxels[i]);
        else if (tissue[labels.voxels[i]] == Tissue::bone)
            bone.add(ct.voxels[i]);
        else if (tissue[labels.voxels[i]] == Tissue::vessel)
            blood.add(ct.voxels[i]);
    }
    return {open.between(kFat), open.between(kSoft), blood.between(kLabelledBlood),
            bone.between(kLabelledBone)};
}

patient::Thresholds thresholdsOf(const TissueClasses& c) {
    patient::Thresholds t;
    // Skin thresholds: the body's rim is a mixture of air and fat, from half air to where fat begins.
    t.t1_hu = std::round(c.fat.mean_hu - kNoNoise * c.fat.sigma_hu);
    t.t0_hu = std::round(std::min(0.5 * (-1000.0 + c.fat.mean_hu), t.t1_hu - 50.0));
    t.t2_sensitive_hu = std::round(c.soft.mean_hu + kNoNoise * c.soft.sigma_hu);
    if (c.bone.share > 0.0)
        t.t2_sensitive_hu = std::max(t.t2_sensitive_hu, std::round(border(c.soft, c.bone)));
    t.t2_specific_hu = t.t2_sensitive_hu;
    if (c.blood.share > 0.0)
        t.t2_specific_hu = std::max(t.t2_specific_hu, std::round(c.blood.mean_hu + 4.0 * c.blood.sigma_hu));
    return t;
}

}  // namespace stylet::modeller
