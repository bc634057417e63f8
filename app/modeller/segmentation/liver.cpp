#include "app/modeller/segmentation/liver.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "app/modeller/image/graph_cut.h"
#include "app/modeller/image/morphology.h"
#include "app/modeller/image/vector_field.h"
#include "app/modeller/segmentation/coarse_grid.h"
#include "app/modeller/segmentation/liver_border.h"
#include "app/modeller/segmentation/liver_neighbours.h"

namespace stylet::modeller {

namespace {

// No voxel of an organ is darker than this, even if half of it is another tissue at a border.
constexpr float kOrganFloor_hu = 0.0f;
constexpr float kMostlyOpen = 0.7f;  // minimum share of a voxel of the first cut where organs can be
// Organs of an atlas may lie elsewhere than those of this patient: uncertainty of their position, and
// probability that the prior is entirely wrong.
constexpr double kPriorBlur_m = 0.010;
constexpr float kPriorDoubt = 0.15f;
constexpr float kAnyLiver = 0.2f;  // prior probability of liver where nothing is known
constexpr float kCore = 0.7f;      // minimum prior for voxels that show the liver's CT values
// Without a prior, the liver is found by its thickness: no other organ is this thick.
constexpr double kThick_m = 0.018;
// In a liver: the share of darker tissue (lesions) and of brighter tissue (vessels), and the maximum
// difference. In a bright liver, lesions may be as dark as kLesion_hu: they take up little contrast medium.
constexpr float kLesion_hu = 45.0f;
constexpr float kDark = 0.15f, kDarker_hu = 70.0f, kBright = 0.03f, kBrighter_hu = 100.0f;
// Fat in the liver and the flow of contrast medium are uneven. In a share kUneven of the liver, the spread is
// kUnevenSigmas times that of noise.
constexpr float kUneven = 0.25f, kUnevenSigmas = 2.0f;
// First cut: limit of one voxel's evidence, and cost of separating two similar voxels.
constexpr float kMaxEvidence = 4.0f, kLink = 1.6f, kMinLink = 0.1f;
constexpr float kMinSigma_hu = 5.0f;
// The liver, except at its edges, is thicker than twice the neck. The walls of stomach, colon and
// gallbladder, which may look similar and touch it, are thinner.
constexpr double kNeck_m = 0.006, kLiverEdge_m = 0.009;
// Second cut of the same voxels: neighbours within noise are averaged, and the liver's level is measured
// locally in its interior.
constexpr float kNoiseSigmas = 2.5f, kLevelCore = 0.5f;
constexpr double kCalm_m = 0.004, kLevel_m = 0.015, kLevelDepth_m = 0.006;
// A full duodenum and the head of the pancreas are narrower than twice this.
constexpr double kLump_m = 0.015;
constexpr float kSimilarSigmas = 2.5f;
// Tumours at the surface: minimum prior, maximum width, depth, and minimum share of their border that is
// liver.
constexpr float kPossible = 0.1f;
constexpr double kBite_m = 0.050, kBiteDepth_m = 0.004, kBiteContact = 0.4, kMinBite_ml = 1.0;
constexpr int kMaxBites = 8;
// Tumours reach farther out than their bites. Near a bite, the share kTumour of the liver has the bite's CT
// values, with at least this spread; each other value has the probability kRareTumour per HU.
// In a real patient as it is and with the contrast of 80 kV, a reach of 8 to 16 mm, a share of 0.35 to 0.65
// and a probability of 2e-4 to 1e-3, varied one at a time, change the Dice coefficient by at most 4e-4.
constexpr double kTumourReach_m = 0.012;
constexpr float kTumour = 0.5f, kMinTumourSigma_hu = 8.0f, kRareTumour = 5e-4f;
constexpr double kMinLiver_ml = 150.0;
constexpr double kMuchRemoved_ml = 50.0;  // outside the ribs; more is reported

// Frequency of CT values, per HU.
class Density {
  public:
    void add(float hu, float weight) { bins_[bin(hu)] += weight, total_ += weight; }
    bool empty() const { return total_ < kMinWeight; }
    void normalise() {
        for (int pass = 0; pass < 2; ++pass) {
            auto smooth = bins_;
            for (std::size_t b = 1; b + 1 < bins_.size(); ++b)
                smooth[b] = 0.25f * (bins_[b - 1] + 2.0f * bins_[b] + bins_[b + 1]);
            bins_ = smooth;
        }
        for (float& b : bins_)
            b = b / (std::max(total_, 1.0f) * kBin_hu) + kRare;
    }
    // Removes a range: replaces it by the line between its ends, where that is lower.
    void interpolateAcross(float low_hu, float high_hu) {
        const std::size_t from = bin(low_hu), to = bin(high_hu);
        for (std::size_t b = from + 1; b < to; ++b) {
            const float t = float(b - from) / float(to - from);
            bins_[b] = std::min(bins_[b], (1.0f - t) * bins_[from] + t * bins_[to]);
        }
    }
    void atLeastUniform() {
        for (std::size_t b = bin(kMinLiver_hu); b <= bin(kMaxLiver_hu); ++b)
            bins_[b] = std::max(bins_[b], 1.0f / (kMaxLiver_hu - kMinLiver_hu));
    }
    float operator()(float hu) const { return bins_[bin(hu)]; }
    float peak(float low_hu, float high_hu) const {
        const auto best = std::max_element(bins_.begin() + std::ptrdiff_t(bin(low_hu)),
                                           bins_.begin() + std::ptrdiff_t(bin(high_hu)));
        return kMin_hu + kBin_hu * (float(best - bins_.begin()) + 0.5f);
    }

  private:
    static constexpr float kMin_hu = -200.0f, kBin_hu = 4.0f, kRare = 1e-5f, kMinWeight = 200.0f;
    static std::size_t bin(float hu) {
        return std::size_t(std::clamp((hu - kMin_hu) / kBin_hu, 0.0f, 149.0f));
    }
    std::array<float, 150> bins_{};
    float total_ = 0.0f;
};

// The patient at the voxel size of the first cut.
struct Coarse {
    FloatVolume hu;
    Mask organ;                      // voxels where organs can be
    std::vector<FloatVolume> prior;  // one per Organ, blurred and mixed with doubt
    bool known = false;              // at least one atlas contributed
};

std::vector<FloatVolume> blendPrior(const AtlasPrior& prior, const Grid& grid, bool& known) {
    std::vector<FloatVolume> out(kOrgans, FloatVolume(grid, (1.0f - kAnyLiver) / float(kOrgans - 1)));
    out[std::size_t(Organ::liver)] = FloatVolume(grid, kAnyLiver);
    known = !prior.used.empty() && prior.probability.size() == kOrgans;
    if (!known) return out;
    // Two box means of this reach approximate the blur.
    const int reach = std::max(1, int(std::lround(0.85 * kPriorBlur_m / prior.grid.spacing_m.x)));
    const auto blurred = [&](const FloatVolume& v) { return boxMean(boxMean(v, reach), reach); };
    FloatVolume some = prior.known;
    for (float& k : some.voxels)
        k = k > 0.0f;
    some = blurred(some);
    for (std::size_t organ = 0; organ < kOrgans; ++organ) {
        const FloatVolume p = blurred(prior.probability[organ]);
        parallelVoxels(grid, [&](const Index3& i) {
            const Vec3 at = grid.centre(i);
            const float share = valueAt(some, at, 0.0f);
            if (share < 0.01f) return;
            float& o = out[organ][i];
            o = kPriorDoubt * o + (1.0f - kPriorDoubt) * valueAt(p, at, 0.0f) / share;
        });
    }
    return out;
}

Coarse makeCoarse(const CtVolume& ct, const Mask& open, const AtlasPrior& prior, double spacing_m) {
    const double voxel_m = ct.grid.spacing_m.x;
    const Grid grid = coarseGrid(ct.grid, voxel_m * std::max(1.0, std::round(spacing_m / voxel_m)));
    Coarse c;
    c.hu = coarseMean(grid, ct.grid, [&](std::size_t i) { return float(ct.voxels[i]); });
    const FloatVolume share = coarseMean(grid, ct.grid, [&](std::size_t i) { return float(open.voxels[i]); });
    c.organ = maskWhere(grid, [&](std::size_t i) {
        return share.voxels[i] > kMostlyOpen && c.hu.voxels[i] > kOrganFloor_hu;
    });
    c.prior = blendPrior(prior, grid, c.known);
    return c;
}

// The voxels that show the liver's own CT values.
Mask findCore(const Coarse& c) {
    Mask core = maskWhere(c.hu.grid, [&](std::size_t i) {
        return c.organ.voxels[i] && c.hu.voxels[i] > kMinLiver_hu && c.hu.voxels[i] < kMaxLiver_hu;
    });
    if (!c.known) {
        core = eroded(core, kThick_m);
        keepLargestComponent(core);
        return core;
    }
    for (std::size_t i = 0; i < core.voxels.size(); ++i)
        core.voxels[i] = core.voxels[i] && c.prior[std::size_t(Organ::liver)].voxels[i] > kCore;
    return core;
}

// Finds the peak and the spread around it. Tumours, vessels and other tissue in the core do not widen the
// spread.
std::optional<Parenchyma> estimateParenchyma(const Coarse& c, const Mask& core) {
    Density density;
    for (std::size_t i = 0; i < core.voxels.size(); ++i)
        if (core.voxels[i]) density.add(c.hu.voxels[i], 1.0f);
    if (density.empty()) return std::nullopt;
    density.normalise();
    Parenchyma p{density.peak(kMinLiver_hu, kMaxLiver_hu), 15.0f};
    for (int pass = 0; pass < 5; ++pass) {
        double n = 0.0, sum = 0.0, squares = 0.0;
        for (std::size_t i = 0; i < core.voxels.size(); ++i) {
            const double d = double(c.hu.voxels[i] - p.mean_hu);
            if (!core.voxels[i] || std::abs(d) > 2.0 * double(p.sigma_hu)) continue;
            n += 1.0, sum += d, squares += d * d;
        }
        if (n < 2.0) break;
        // A normal distribution cut at two sigma has 0.88 of its spread.
        p.sigma_hu = std::max(kMinSigma_hu, float(std::sqrt(squares / n - sum * sum / n / n) / 0.88));
        p.mean_hu += float(sum / n);
    }
    return p;
}

// Maximum difference of a lesion from the liver.
float lesionRange(const Parenchyma& liver) {
    return std::max(kDarker_hu, liver.mean_hu - kLesion_hu);
}

// Estimates the distribution of CT values of each organ except the liver, in this patient. Where the prior is
// wrong, the samples contain liver. Liver values are therefore removed from every distribution except that of
// the spleen, which may look exactly like liver. Stomach, bowel and pancreas have walls and mixed contents,
// so every value keeps a small probability.
std::vector<Density> estimateDensities(const Coarse& c, const Parenchyma& liver) {
    std::vector<Density> densities(kOrgans);
    Density all;
    for (std::size_t i = 0; i < c.organ.voxels.size(); ++i) {
        if (!c.organ.voxels[i]) continue;
        const float hu = c.hu.voxels[i];
        all.add(hu, 1.0f);
        for (std::size_t organ = 0; organ < kOrgans; ++organ)
            if (const float p = c.prior[organ].voxels[i]; p > 0.5f) densities[organ].add(hu, p);
    }
    const auto normalise = [&](Density& d) {
        d.normalise();
        d.interpolateAcross(liver.mean_hu - 2.5f * liver.sigma_hu, liver.mean_hu + 2.5f * liver.sigma_hu);
    };
    normalise(all);
    for (std::size_t o = 0; o < kOrgans; ++o) {
        Density& d = densities[o];
        const auto organ = Organ(o);
        if (d.empty())
            d = all;
        else if (organ == Organ::spleen)
            d.normalise();
        else
            normalise(d);
        if (organ == Organ::stomach || organ == Organ::bowel || organ == Organ::pancreas) d.atLeastUniform();
    }
    return densities;
}

// Log-odds of liver at each voxel by Bayes' theorem, from the prior, the densities of the other organs and
// `liver_density`, the frequency of a CT value in the liver.
FloatVolume logOdds(const Coarse& c, const std::vector<Density>& densities, const auto& liver_density) {
    FloatVolume log_odds(c.hu.grid);
    parallelVoxels(c.hu.grid, [&](const Index3& i) {
        if (!c.organ[i]) return;
        const float hu = c.hu[i];
        float other = 0.0f;
        for (std::size_t organ = 0; organ < kOrgans; ++organ)
            if (Organ(organ) != Organ::liver) other += c.prior[organ][i] * densities[organ](hu);
        const float liver_too = c.prior[std::size_t(Organ::liver)][i] * liver_density(hu);
        log_odds[i] = std::clamp(std::log(liver_too / other), -kMaxEvidence, kMaxEvidence);
    });
    return log_odds;
}

float normalDensity(float hu, float mean_hu, float sigma_hu) {
    const float d = (hu - mean_hu) / sigma_hu;
    return std::exp(-0.5f * d * d) / (2.5066f * sigma_hu);
}

FloatVolume computeEvidence(const Coarse& c, const Parenchyma& liver) {
    const float darker_hu = lesionRange(liver);
    return logOdds(c, estimateDensities(c, liver), [&](float hu) {
        float p = (1.0f - kDark - kBright) *
                  ((1.0f - kUneven) * normalDensity(hu, liver.mean_hu, liver.sigma_hu) +
                   kUneven * normalDensity(hu, liver.mean_hu, kUnevenSigmas * liver.sigma_hu));
        if (hu > liver.mean_hu - darker_hu && hu < liver.mean_hu) p += kDark / darker_hu;
        if (hu > liver.mean_hu && hu < liver.mean_hu + kBrighter_hu) p += kBright / kBrighter_hu;
        return p + 1e-6f;
    });
}

// The cheapest cut through the voxels of `c` where organs can be. Separating similar voxels is expensive; a
// difference of `edge_hu` is an edge.
CutProblem coarseProblem(const Coarse& c, FloatVolume preference, float edge_hu) {
    CutProblem problem;
    problem.state = Mask(c.hu.grid, std::uint8_t(CutState::background));
    for (std::size_t i = 0; i < c.organ.voxels.size(); ++i)
        if (c.organ.voxels[i]) problem.state.voxels[i] = std::uint8_t(CutState::free);
    problem.preference = std::move(preference);
    problem.link = [&c, edge_hu](std::size_t i, std::size_t k) {
        const float d = (c.hu.voxels[i] - c.hu.voxels[k]) / edge_hu;
        return kLink * std::max(kMinLink, std::exp(-0.5f * d * d));
    };
    return problem;
}

// Removes parts connected to the main body through a neck thinner than kNeck_m. Keeps the main body's own
// thin edges.
void keepThickest(Mask& mask) {
    Mask thick = eroded(mask, kNeck_m);
    keepLargestComponent(thick);
    mask = intersect(std::move(mask), dilated(thick, kLiverEdge_m));
    keepLargestComponent(mask);
}

Mask coarseCut(const Coarse& c, const Parenchyma& liver) {
    return minimumCut(coarseProblem(c, computeEvidence(c, liver), 2.0f * liver.sigma_hu));
}

// Reduces noise and unevenness in `c` and `liver`, because pancreas and duodenum differ from liver by less
// than either.
void denoise(Coarse& c, Parenchyma& liver, const Mask& first) {
    const auto voxels = [&](double m) { return std::max(1, int(std::lround(m / c.hu.grid.spacing_m.x))); };
    Mask core = eroded(first, kLevelDepth_m);
    for (std::size_t i = 0; i < core.voxels.size(); ++i)
        core.voxels[i] = core.voxels[i] &&
                         (!c.known || c.prior[std::size_t(Organ::liver)].voxels[i] > kLevelCore) &&
                         std::abs(c.hu.voxels[i] - liver.mean_hu) < 2.0f * liver.sigma_hu;
    c.hu = correctBias(sigmaFiltered(c.hu, c.organ, kNoiseSigmas * liver.sigma_hu, voxels(kCalm_m)), core,
                       liver.mean_hu, voxels(kLevel_m));
    if (const std::optional<Parenchyma> updated = estimateParenchyma(c, core)) liver = *updated;
}

// Segments the liver, accurate to one or two voxels. Where a cut ran through another organ that looks like
// liver, that organ is removed from the allowed region: from `c.organ`, and from `open` on the CT's grid.
Mask segmentCoarse(Coarse& c, const Parenchyma& parenchyma, Mask& open) {
    Coarse denoised = c;
    Parenchyma liver = parenchyma;
    Mask cut = coarseCut(denoised, liver);
    keepLargestComponent(cut);
    closeLiver(cut, c.organ);  // without its vessels and ducts, the liver has thin parts everywhere
    keepThickest(cut);
    denoise(denoised, liver, cut);
    cut = coarseCut(denoised, liver);
    keepLargestComponent(cut);
    closeLiver(cut, c.organ);
    Mask similar = subtract(c.organ, cut);
    for (std::size_t i = 0; i < similar.voxels.size(); ++i)
        similar.voxels[i] = similar.voxels[i] &&
                            std::abs(denoised.hu.voxels[i] - liver.mean_hu) < kSimilarSigmas * liver.sigma_hu;
    const FloatVolume undecided(c.hu.grid, 0.5f);  // the prior without atlases
    const Mask lumps =
        findLeakedLumps(cut, similar, c.known ? c.prior[std::size_t(Organ::liver)] : undecided, kLump_m);
    cut = subtract(std::move(cut), lumps);
    keepThickest(cut);
    c.organ = subtract(std::move(c.organ), lumps);
    parallelVoxels(open.grid, [&](const Index3& i) {
        if (lumps.nearestOr(open.grid.centre(i), 0)) open[i] = 0;
    });
    return cut;
}

// Adds the rest of a tumour at the liver's surface. `bite` is the part that was found. The rest is the
// cheapest cut near it for an organ that has the bite's CT values.
void completeTumour(Mask& liver, const Mask& bite, const Coarse& c, const std::vector<Density>& densities) {
    double n = 0.0, sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < bite.voxels.size(); ++i) {
        if (!bite.voxels[i]) continue;
        const auto hu = double(c.hu.voxels[i]);
        n += 1.0, sum += hu, squares += hu * hu;
    }
    const auto mean_hu = float(sum / n);
    const float sigma_hu = std::max(kMinTumourSigma_hu, float(std::sqrt(squares / n - sum * sum / n / n)));
    CutProblem problem = coarseProblem(
        c,
        logOdds(c, densities,
                [&](float hu) { return kTumour * normalDensity(hu, mean_hu, sigma_hu) + kRareTumour; }),
        2.0f * sigma_hu);
    const Mask near = dilated(bite, kTumourReach_m);
    for (std::size_t i = 0; i < near.voxels.size(); ++i)
        if (liver.voxels[i] || !near.voxels[i] || c.prior[std::size_t(Organ::liver)].voxels[i] <= kPossible)
            problem.state.voxels[i] = std::uint8_t(liver.voxels[i] ? CutState::object : CutState::background);
    liver = minimumCut(problem);
}

// Adds tumours at the surface, which appear as bites out of the liver's outline. A bite is darker than liver,
// thick enough, possible according to the prior, and mostly bordered by liver.
void addBites(Mask& liver, const Coarse& c, const Parenchyma& parenchyma) {
    Mask bites = closed(liver, kBite_m);
    for (std::size_t i = 0; i < bites.voxels.size(); ++i) {
        const float darker = parenchyma.mean_hu - c.hu.voxels[i];
        bites.voxels[i] = bites.voxels[i] && !liver.voxels[i] && c.organ.voxels[i] &&
                          darker > 2.0f * parenchyma.sigma_hu && darker < lesionRange(parenchyma) &&
                          c.prior[std::size_t(Organ::liver)].voxels[i] > kPossible;
    }
    bites = intersect(bites, dilated(eroded(bites, kBiteDepth_m), 2.0 * kBiteDepth_m));
    const Mask before = liver;
    const std::vector<Density> densities = estimateDensities(c, parenchyma);
    for (int n = 0; n < kMaxBites; ++n) {
        Mask bite = bites;
        keepLargestComponent(bite);
        if (volume_ml(bite) < kMinBite_ml) return;
        double border = 0.0, with_liver = 0.0;
        const Grid& g = bite.grid;
        forEachVoxel(VoxelBox{Index3(1), g.dims - 2}, [&](const Index3& i) {
            if (!bite[i]) return;
            forEachNeighbour(g, i, Connectivity::faces, [&](std::size_t to) {
                border += !bite.voxels[to];
                with_liver += before.voxels[to] != 0;
            });
        });
        bites = subtract(std::move(bites), bite);
        if (with_liver <= kBiteContact * border) continue;
        liver = unite(std::move(liver), bite);
        completeTumour(liver, bite, c, densities);
    }
}

// The ribs limit the liver also where muscle between them looks like it. Clears what lies outside the ribs'
// inner side in the first cut and in the region `open` to the second, and keeps the largest part of the first
// cut. If blur hides the diaphragm, 2 mm are left for it. Wide voxels blur too; they do not count.
void limitByRibs(const CtVolume& ct, const Mask& body, const Mask& lungs, const Mask& bones, double blur_m,
                 Mask& first, Mask& open) {
    constexpr double kThinDiaphragm_m = 0.002;
    Mask liver(ct.grid);
    parallelVoxels(ct.grid, [&](const Index3& i) { liver[i] = first.nearestOr(ct.grid.centre(i), 0); });
    const Mask organs = unite(liver, lungs), uncalcified = subtract(bones, calcifiedLiver(bones, liver));
    const Mask wall_bones = wallBones({ct, body, uncalcified, organs});
    const bool hidden = blur_m > std::max(kHidesDiaphragm_m, ct.grid.spacing_m.x);
    removeOutsideRibs({ct, body, wall_bones, lungs}, hidden ? kThinDiaphragm_m : 0.0, {&first, &open});
    keepLargestComponent(first);
}

}  // namespace

Liver findLiver(const CtVolume& ct, const Mask& body, const Mask& lungs, const Mask& bones,
                const AtlasPrior& prior, const LiverSettings& settings) {
    Mask open = subtract(subtract(body, lungs), bones);
    Liver liver;
    liver.mask = Mask(ct.grid);
    Coarse coarse = makeCoarse(ct, open, prior, settings.coarse_m);
    if (!coarse.known) liver.notes.push_back("liver: no atlas, the largest thick organ was taken");
    const std::optional<Parenchyma> parenchyma = estimateParenchyma(coarse, findCore(coarse));
    if (!parenchyma) {
        liver.notes.push_back("no liver: nothing in the scan is like one where it should lie");
        return liver;
    }
    liver.mean_hu = double(parenchyma->mean_hu);
    liver.sigma_hu = double(parenchyma->sigma_hu);
    Mask first = segmentCoarse(coarse, *parenchyma, open);
    closeLiver(first, coarse.organ);
    addBites(first, coarse, *parenchyma);
    fillCavities(first);
    const double whole_ml = volume_ml(first);
    limitByRibs(ct, body, lungs, bones, settings.blur_m, first, open);
    if (const double removed_ml = whole_ml - volume_ml(first); removed_ml > kMuchRemoved_ml)
        liver.notes.push_back(
            fmt::format("liver: {:.0f} ml that lay outside the ribs' inner side were removed", removed_ml));
    if (volume_ml(first) < kMinLiver_ml) {
        liver.notes.push_back("no liver: what is like one is too small");
        return liver;
    }
    liver.mask = refineLiver(ct, open, first, *parenchyma, settings.band_m, settings.blur_m);
    return liver;
}

Mask calcifiedLiver(const Mask& dense, const Mask& liver) {
    constexpr double kTouching_m = 0.005;
    const Mask near = dilated(liver, kTouching_m);
    const Components pieces = findComponents(surroundedPieces(dense, liver), Connectivity::corners);
    std::vector<bool> touches(pieces.size.size(), false);
    for (std::size_t i = 0; i < near.voxels.size(); ++i)
        if (near.voxels[i]) touches[std::size_t(pieces.number.voxels[i])] = true;
    return componentsWhere(pieces, [&](std::size_t n) { return touches[n]; });
}

}  // namespace stylet::modeller
