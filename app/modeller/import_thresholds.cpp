#include "app/modeller/import_thresholds.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/import_map.h"

namespace stylet::modeller {

using patient::Tissue;

namespace {

// A voxel of noise must not turn muscle into bone or fat into skin under the needle: 5.5 sigma is one voxel
// in fifty million.
constexpr double kNoNoise = 5.5;

struct Normal {
    double mean = 0.0, sigma = 0.0, count = 0.0;
};

// Mean and spread of the values in low..high around the histogram's peak there: once over everything, then
// within two sigma of the first answer, so that neighbours' tails do not widen it.
class Histogram {
  public:
    static constexpr int kLowest = -1024, kBins = 4096;
    void add(int hu) { counts_[std::size_t(std::clamp(hu - kLowest, 0, kBins - 1))] += 1.0; }
    Normal between(double low, double high) const {
        Normal n = moments(low, high);
        for (int i = 0; i < 3; ++i)
            n = moments(std::max(low, n.mean - 2.0 * n.sigma), std::min(high, n.mean + 2.0 * n.sigma));
        n.sigma *= 1.137;  // of a normal cut at two sigma
        return n;
    }

  private:
    Normal moments(double low, double high) const {
        Normal n;
        double squares = 0.0;
        for (int b = 0; b < kBins; ++b) {
            const double hu = b + kLowest, c = counts_[std::size_t(b)];
            if (hu < low || hu > high) continue;
            n.count += c, n.mean += c * hu, squares += c * hu * hu;
        }
        if (n.count == 0.0) return {0.5 * (low + high), 1.0, 0.0};
        n.mean /= n.count;
        n.sigma = std::max(1.0, std::sqrt(std::max(0.0, squares / n.count - n.mean * n.mean)));
        return n;
    }
    std::array<double, kBins> counts_{};
};

// Where two normal distributions of equal weight cross between their means.
double border(const Normal& a, const Normal& b) {
    double low = a.mean, high = b.mean;
    const auto likelier_b = [&](double x) {
        const double za = (x - a.mean) / a.sigma, zb = (x - b.mean) / b.sigma;
        return -0.5 * zb * zb - std::log(b.sigma) > -0.5 * za * za - std::log(a.sigma);
    };
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (likelier_b(middle) ? high : low) = middle;
    }
    return 0.5 * (low + high);
}

}  // namespace

patient::Thresholds thresholdsOf(const patient::CtVolume& ct, const patient::LabelVolume& labels,
                                 const Mask& body) {
    std::array<Tissue, 256> tissue{};
    for (const patient::Label& l : targetTable())
        tissue[l.id] = l.tissue;
    Histogram open, bone, vessel;
    for (std::size_t i = 0; i < ct.voxels.size(); ++i) {
        if (!body.voxels[i]) continue;
        if (labels.voxels[i] == 0)
            open.add(ct.voxels[i]);
        else if (tissue[labels.voxels[i]] == Tissue::bone)
            bone.add(ct.voxels[i]);
        else if (tissue[labels.voxels[i]] == Tissue::vessel)
            vessel.add(ct.voxels[i]);
    }
    const Normal fat = open.between(-200.0, -30.0), soft = open.between(0.0, 130.0);
    const Normal bones = bone.between(150.0, 3000.0), vessels = vessel.between(0.0, 600.0);
    patient::Thresholds t;
    // The body's rim, air mixed into fat: from half air to where fat begins.
    t.t1_hu = std::round(fat.mean - kNoNoise * fat.sigma);
    t.t0_hu = std::round(std::min(0.5 * (-1000.0 + fat.mean), t.t1_hu - 50.0));
    t.t2_sensitive_hu = std::round(soft.mean + kNoNoise * soft.sigma);
    if (bones.count > 0.0) t.t2_sensitive_hu = std::max(t.t2_sensitive_hu, std::round(border(soft, bones)));
    t.t2_specific_hu = std::max(t.t2_sensitive_hu,
                                vessels.count > 0.0 ? std::round(vessels.mean + 4.0 * vessels.sigma) : 0.0);
    return t;
}

}  // namespace stylet::modeller
