#include "app/modeller/segmentation/liver_border.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/image/graph_cut.h"
#include "app/modeller/image/morphology.h"
#include "app/modeller/image/vector_field.h"

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

// Distance to the nearest voxel on the other side of the mask's border: positive inside, negative outside.
FloatVolume signedDepth(const Mask& mask) {
    FloatVolume depth = distanceTo(inverted(mask));
    const FloatVolume out = distanceTo(mask);
    for (std::size_t i = 0; i < depth.voxels.size(); ++i)
        depth.voxels[i] -= out.voxels[i];
    return depth;
}

// Moves the border of `first` by at most the band, on the CT's own voxels.
Mask fineCut(const FloatVolume& hu, const Mask& open, const Mask& first, const Parenchyma& liver,
             float band_m) {
    const Grid& g = hu.grid;
    const FloatVolume depth = signedDepth(first);
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

// --- Profiles across the border ---

// Samples of a profile along the outward normal, relative to the border of the cut. Each is the mean of nine
// samples, kAcross_m apart in the plane of the border.
constexpr double kSample_m = 0.0005, kAcross_m = 0.0015;
constexpr int kFirstSample = -6, kSamples = 14;
using Profile = std::array<float, kSamples>;  // differences from liver
// Positions of the border that are compared, and widths of the fat between liver and its neighbour. Fat that
// is wider than the profile is itself the neighbour.
constexpr int kShiftSteps = 10;
constexpr double kShiftStep_m = 0.00025, kMaxShift_m = kShiftSteps * kShiftStep_m;
constexpr std::array kFilms_m{0.0, 0.0005, 0.001, 0.0015, 0.002, 0.003, 1.0};
// Blur of a profile beyond that of the scan: of the samples between voxels (standard deviation). Value of the
// fat.
constexpr double kSampleBlur_m = 0.00047;
constexpr float kFilm_hu = -105.0f;
// Standard deviation of the noise of a profile. Expected before the fit, with standard deviations: the
// neighbour's difference from liver, and the shift (0).
constexpr float kProfileNoise_hu = 8.5f, kNeighbour_hu = -30.0f, kNeighbourSpread_hu = 60.0f;
constexpr double kUsualShift_m = 0.001;
constexpr float kLungOrGas_hu = -160.0f;  // darker than any fat: lung or gas
// Weights: 1 / variance, in 1 / mm^2. kMinEdgeWeight is that of a single profile which shows nothing, as a
// mean over the neighbours of a voxel.
constexpr float kMaxEdgeWeight = 50.0f, kMinEdgeWeight = 1e-4f;

double blurredStep(double x_m, double blur_m) {
    return 0.5 * (1.0 + std::erf(x_m / (blur_m * std::sqrt(2.0))));
}

// A border at a position, with a film of fat. Shapes of the film and of the tissue behind it along the
// profile, each between 0 and 1.
struct ProfileModel {
    double shift_m = 0.0;
    Profile film{}, behind{};
    float film_film = 0.0f, film_behind = 0.0f, behind_behind = 0.0f;  // dot products
};

using ProfileModels = std::array<ProfileModel, (2 * kShiftSteps + 1) * kFilms_m.size()>;

ProfileModels makeProfileModels(double scan_blur_m) {
    const double blur_m = std::hypot(scan_blur_m, kSampleBlur_m);
    ProfileModels models;
    auto model = models.begin();
    for (int step = -kShiftSteps; step <= kShiftSteps; ++step)
        for (const double film_m : kFilms_m) {
            model->shift_m = step * kShiftStep_m;
            for (int k = 0; k < kSamples; ++k) {
                const double x_m = (kFirstSample + k) * kSample_m - model->shift_m;
                const auto behind = float(blurredStep(x_m - film_m, blur_m));
                const float film = float(blurredStep(x_m, blur_m)) - behind;
                model->film[std::size_t(k)] = film, model->behind[std::size_t(k)] = behind;
                model->film_film += film * film, model->film_behind += film * behind;
                model->behind_behind += behind * behind;
            }
            ++model;
        }
    return models;
}

struct EdgePosition {
    float mean_m = 0.0f, weight = 0.0f;
};

// Returns the position of the border in a profile of differences from liver. The mean over all models, each
// weighted by its probability. The neighbour's value is estimated for each model by least squares.
EdgePosition findEdge(const ProfileModels& models, const Profile& profile, float fat_hu) {
    constexpr float kPrior =
        (kProfileNoise_hu / kNeighbourSpread_hu) * (kProfileNoise_hu / kNeighbourSpread_hu);
    std::array<double, std::tuple_size_v<ProfileModels>> misfit;
    for (std::size_t n = 0; n < models.size(); ++n) {
        const ProfileModel& m = models[n];
        float film = 0.0f, behind = 0.0f;
        for (std::size_t k = 0; k < kSamples; ++k)
            film += profile[k] * m.film[k], behind += profile[k] * m.behind[k];
        const float b = behind - fat_hu * m.film_behind + kPrior * kNeighbour_hu;
        const float rest = fat_hu * (fat_hu * m.film_film - 2.0f * film) - b * b / (m.behind_behind + kPrior);
        const double usual = m.shift_m / kUsualShift_m;
        misfit[n] = double(rest / (kProfileNoise_hu * kProfileNoise_hu)) + usual * usual;
    }
    const double best = *std::min_element(misfit.begin(), misfit.end());
    double sum = 0.0, mean = 0.0, squares = 0.0;
    for (std::size_t n = 0; n < models.size(); ++n) {
        const double p = std::exp(0.5 * (best - misfit[n])), x = models[n].shift_m;
        sum += p, mean += p * x, squares += p * x * x;
    }
    mean /= sum;
    const double variance_mm2 = 1e6 * (squares / sum - mean * mean);
    return {float(mean), 1.0f / std::max(1.0f / kMaxEdgeWeight, float(variance_mm2))};
}

// Samples the profile at a point of the border. Returns false if it reaches lung or gas.
bool sampleProfile(const FloatVolume& hu, const Vec3& at_m, const Vec3& normal, float liver_hu,
                   Profile& profile) {
    const Vec3 aside = glm::normalize(
        glm::cross(normal, std::fabs(normal.x) < 0.7 ? Vec3(1.0, 0.0, 0.0) : Vec3(0.0, 1.0, 0.0)));
    const Vec3 up = glm::cross(normal, aside);
    for (int k = 0; k < kSamples; ++k) {
        float sum = 0.0f;
        for (const double a : {-kAcross_m, 0.0, kAcross_m})
            for (const double b : {-kAcross_m, 0.0, kAcross_m})
                sum += valueAt(hu, at_m + (kFirstSample + k) * kSample_m * normal + a * aside + b * up,
                               liver_hu);
        profile[std::size_t(k)] = sum / 9.0f - liver_hu;
        if (sum / 9.0f < kLungOrGas_hu) return false;
    }
    return true;
}

}  // namespace

void closeLiver(Mask& liver, const Mask& open) {
    liver = unite(intersect(closed(liver, kVesselGap_m), open), liver);
    fillCavities(liver);
}

Mask fitBorder(const FloatVolume& hu, const Mask& open, const Mask& cut, const Parenchyma& liver,
               double blur_m) {
    const Grid& g = hu.grid;
    const auto half_voxel_m = float(0.5 * g.spacing_m.x);
    FloatVolume depth = signedDepth(cut);
    LocalMean inside(g);
    for (std::size_t i = 0; i < depth.voxels.size(); ++i) {
        float& d = depth.voxels[i];
        if (d > kClear_m && d < kBeside_m && std::abs(hu.voxels[i] - liver.mean_hu) < kMaxDeviation_hu)
            inside.add(i, hu.voxels[i]);
        d += cut.voxels[i] ? -half_voxel_m : half_voxel_m;
    }
    inside.finish(std::max(1, int(std::lround(double(kBeside_m) / g.spacing_m.x))));
    depth = boxMean(boxMean(depth, 1), 1);  // continuous across the border
    const ProfileModels models = makeProfileModels(blur_m);
    FloatVolume shift(g), weight(g);
    parallelVoxels(g, [&](const Index3& at) {
        if (!cut[at] || g.atBorder(at)) return;
        bool at_surface = false;
        forEachNeighbour(g, at, Connectivity::faces, [&](std::size_t to) { at_surface |= !cut.voxels[to]; });
        if (!at_surface) return;
        Vec3 inward;
        for (int d = 0; d < 3; ++d) {
            Index3 step(0);
            step[d] = 1;
            inward[d] = double(depth[at + step] - depth[at - step]);
        }
        if (!(glm::length(inward) > 0.0)) return;
        const Vec3 normal = -glm::normalize(inward);
        const float liver_hu = inside.at(g.offset(at), liver.mean_hu);
        Profile profile;
        if (!sampleProfile(hu, g.centre(at) + double(depth[at]) * normal, normal, liver_hu, profile)) return;
        const EdgePosition edge = findEdge(models, profile, kFilm_hu - liver_hu);
        shift[at] = edge.weight * edge.mean_m;
        weight[at] = edge.weight;
    });
    const int reach = int(kMaxShift_m / g.spacing_m.x) + 1;
    shift = boxMean(shift, reach), weight = boxMean(weight, reach);
    return maskWhere(g, [&](std::size_t i) {
        const float d = depth.voxels[i];
        if (std::abs(d) > float(kMaxShift_m) || weight.voxels[i] < kMinEdgeWeight) return cut.voxels[i] != 0;
        return d + shift.voxels[i] / weight.voxels[i] > 0.0f && (open.voxels[i] || cut.voxels[i]);
    });
}

Mask refineLiver(const CtVolume& ct, const Mask& open, const Mask& first, const Parenchyma& liver,
                 double band_m, double blur_m) {
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
    const bool fine = hu.grid.spacing_m.x < kNoisyVoxel_m;
    Mask cut = fineCut(fine ? boxMean(hu, 1) : hu, open_here, start, liver, float(band_m));
    closeLiver(cut, open_here);
    keepLargestComponent(cut);
    if (fine) {
        cut = fitBorder(hu, open_here, cut, liver, blur_m);
        keepLargestComponent(cut);
    }
    Mask out(ct.grid);
    parallelVoxels(hu.grid, [&](const Index3& i) { out[low + i] = cut[i]; });
    return out;
}

}  // namespace stylet::modeller
