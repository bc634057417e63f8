#include "app/modeller/segmentation/tube_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/geodesic.h"
#include "base/statistics.h"

namespace stylet::modeller {

namespace {

constexpr double kLineBlur_m = 0.0007;  // halves the noise power and preserves vessels of 1 mm radius
constexpr float kTowardTubes_hu = 120;  // upper limit of the contrast, for bone, gas and metal
constexpr float kAway_hu = 40.0f;       // opposite sign: tumours beside vessels, vessels beside ducts
constexpr float kAwayLine_hu = 15.0f;   // for the line filter: a bridge between holes looks like a tube
constexpr float kMaxScore = 6.0f;       // for each part of the score
constexpr int kLiverMargin = 4;         // voxels around the liver; beyond them the filter repeats the border

// The histogram's peak, and its half width at half maximum on the lower side.
ParenchymaPeak findPeak(const std::vector<float>& values) {
    constexpr int kLow = -200, kBins = 700;
    std::array<double, kBins> count{}, smooth{};
    for (const float v : values)
        count[std::size_t(std::clamp(int(std::floor(v)) - kLow, 0, kBins - 1))] += 1.0;
    constexpr int kWindow = 2;
    for (int i = kWindow; i < kBins - kWindow; ++i)
        for (int j = -kWindow; j <= kWindow; ++j)
            smooth[std::size_t(i)] += count[std::size_t(i + j)];
    const auto top = std::max_element(smooth.begin(), smooth.end());
    auto half = top;
    while (half != smooth.begin() && *half > 0.5 * *top)
        --half;
    const double beyond = half == top ? 0.0 : (0.5 * *top - *half) / (*(half + 1) - *half);
    constexpr double kHalfWidth = 1.17741;  // of a normal distribution, in sigmas
    return {double(top - smooth.begin()) + kLow + 0.5,
            std::max(1.0, (double(top - half) - beyond) / kHalfWidth)};
}

std::vector<float> valuesIn(const FloatVolume& v, const Mask& mask) {
    std::vector<float> values;
    for (std::size_t i = 0; i < v.voxels.size(); ++i)
        if (mask.voxels[i]) values.push_back(v.voxels[i]);
    return values;
}

// Returns the CT minus `mean_hu`, with the sign chosen so that tubes are positive. 0 outside the liver, so
// that its border gives no response.
FloatVolume signedContrast(const CtVolume& ct, const TubeEvidence& e, TubeKind kind, double mean_hu,
                           float away_hu) {
    FloatVolume out(e.liver.grid);
    const float sign = kind == TubeKind::bright ? 1.0f : -1.0f;
    forEachVoxel(out.grid, [&](const Index3& i) {
        if (e.liver[i])
            out[i] =
                std::clamp(sign * (float(ct[e.box.low + i]) - float(mean_hu)), -away_hu, kTowardTubes_hu);
    });
    return out;
}

}  // namespace

float TubeEvidence::score(std::size_t voxel) const {
    const float widths = contrast_hu.voxels[voxel] / float(parenchyma.noise_hu);
    return std::min(kMaxScore, widths) + std::min(kMaxScore, line.voxels[voxel]);
}

TubeEvidence tubeEvidence(const CtVolume& ct, const Mask& liver, TubeKind kind,
                          const std::vector<double>& radii_m) {
    TubeEvidence e;
    e.box = boxAround(liver, kLiverMargin);
    e.liver = cropped(liver, e.box);

    const FloatVolume raw = signedContrast(ct, e, TubeKind::bright, 0.0, 1e4f);
    e.parenchyma.mean_hu = findPeak(valuesIn(raw, e.liver)).mean_hu;
    e.contrast_hu = gaussian(signedContrast(ct, e, kind, e.parenchyma.mean_hu, kAway_hu), kLineBlur_m);
    const ParenchymaPeak left = findPeak(valuesIn(e.contrast_hu, e.liver));
    e.parenchyma.mean_hu += kind == TubeKind::bright ? left.mean_hu : -left.mean_hu;
    e.parenchyma.noise_hu = left.noise_hu;
    for (std::size_t i = 0; i < e.liver.voxels.size(); ++i)
        e.contrast_hu.voxels[i] = e.liver.voxels[i] ? e.contrast_hu.voxels[i] - float(left.mean_hu) : 0.0f;

    const FloatVolume image = signedContrast(ct, e, kind, e.parenchyma.mean_hu, kAwayLine_hu);
    e.line = FloatVolume(e.liver.grid);
    for (const double radius : radii_m) {
        const FloatVolume response = tubeResponse(image, e.liver, radius / std::sqrt(2.0), TubeKind::bright);
        // A liver without noise has no random response; 0.5 HU is the effect of rounding to whole HU.
        const float chance = std::max(0.5f, lowerQuantile(valuesIn(response, e.liver), 0.9));
        for (std::size_t i = 0; i < response.voxels.size(); ++i)
            e.line.voxels[i] = std::max(e.line.voxels[i], response.voxels[i] / chance);
    }
    return e;
}

Mask filterComponents(const Mask& mask, const std::function<bool(const Piece&)>& keep) {
    Mask out(mask.grid);
    std::vector<bool> seen(mask.voxels.size(), false);
    for (std::size_t seed = 0; seed < mask.voxels.size(); ++seed) {
        if (!mask.voxels[seed] || seen[seed]) continue;
        const Piece piece =
            connectedVoxels(mask.grid, seed, [&](std::size_t o) { return mask.voxels[o] != 0; }, seen);
        if (!keep(piece)) continue;
        for (const std::size_t o : piece)
            out.voxels[o] = 1;
    }
    return out;
}

}  // namespace stylet::modeller
