#include "app/modeller/segmentation/tube_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/statistics.h"

namespace stylet::modeller {

namespace {

constexpr double kLineBlur_m = 0.0007;  // halves the noise power and preserves vessels of 1 mm radius
constexpr float kTowardTubes_hu = 120;  // higher contrast adds no certainty: bone, gas, metal
constexpr float kAway_hu = 40.0f;       // tumours beside vessels, vessels beside ducts
constexpr float kAwayLine_hu = 15.0f;   // for the line filter, which sees a bridge between holes as a tube
constexpr float kMostScore = 6.0f;      // for each part of the score
constexpr int kLiverMargin = 4;         // voxels around the liver; beyond them the filter repeats the border

// The histogram's peak, and its half width at half maximum on the lower side.
ParenchymaPeak peakOf(const std::vector<float>& values) {
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

// The CT minus `mean`, with the sign chosen so that tubes are positive. 0 outside the liver, so that its
// border gives no response.
FloatVolume turned(const CtVolume& ct, const TubeEvidence& e, TubeKind kind, double mean_hu, float away_hu) {
    FloatVolume out(e.liver.grid);
    const float sign = kind == TubeKind::bright ? 1.0f : -1.0f;
    std::size_t o = 0;
    for (int z = e.box.low.z; z <= e.box.high.z; ++z)
        for (int y = e.box.low.y; y <= e.box.high.y; ++y)
            for (int x = e.box.low.x; x <= e.box.high.x; ++x, ++o)
                if (e.liver.voxels[o])
                    out.voxels[o] =
                        std::clamp(sign * (float(ct[{x, y, z}]) - float(mean_hu)), -away_hu, kTowardTubes_hu);
    return out;
}

}  // namespace

float TubeEvidence::score(std::size_t voxel) const {
    const float widths = contrast_hu.voxels[voxel] / float(parenchyma.noise_hu);
    return std::min(kMostScore, widths) + std::min(kMostScore, line.voxels[voxel]);
}

TubeEvidence tubeEvidence(const CtVolume& ct, const Mask& liver, TubeKind kind,
                          const std::vector<double>& radii_m) {
    TubeEvidence e;
    e.box = boxAround(liver, kLiverMargin);
    e.liver = cropped(liver, e.box);

    const FloatVolume raw = turned(ct, e, TubeKind::bright, 0.0, 1e4f);
    e.parenchyma.mean_hu = peakOf(valuesIn(raw, e.liver)).mean_hu;
    e.contrast_hu = gaussian(turned(ct, e, kind, e.parenchyma.mean_hu, kAway_hu), kLineBlur_m);
    const ParenchymaPeak left = peakOf(valuesIn(e.contrast_hu, e.liver));
    e.parenchyma.mean_hu += kind == TubeKind::bright ? left.mean_hu : -left.mean_hu;
    e.parenchyma.noise_hu = left.noise_hu;
    for (std::size_t i = 0; i < e.liver.voxels.size(); ++i)
        e.contrast_hu.voxels[i] = e.liver.voxels[i] ? e.contrast_hu.voxels[i] - float(left.mean_hu) : 0.0f;

    const FloatVolume image = turned(ct, e, kind, e.parenchyma.mean_hu, kAwayLine_hu);
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

Mask keepPieces(const Mask& mask, const std::function<bool(const Piece&)>& keep) {
    const Grid& g = mask.grid;
    Mask rest = mask, out(g);
    Piece piece;
    for (std::size_t seed = 0; seed < rest.voxels.size(); ++seed) {
        if (!rest.voxels[seed]) continue;
        piece.assign(1, seed);
        rest.voxels[seed] = 0;
        for (std::size_t head = 0; head < piece.size(); ++head) {
            const Index3 at = g.voxelAt(piece[head]);
            const Index3 low = glm::max(at - 1, Index3(0)), high = glm::min(at + 1, g.dims - 1);
            for (int z = low.z; z <= high.z; ++z)
                for (int y = low.y; y <= high.y; ++y)
                    for (int x = low.x; x <= high.x; ++x) {
                        const std::size_t o = g.offset({x, y, z});
                        if (!rest.voxels[o]) continue;
                        rest.voxels[o] = 0;
                        piece.push_back(o);
                    }
        }
        if (!keep(piece)) continue;
        for (const std::size_t o : piece)
            out.voxels[o] = 1;
    }
    return out;
}

}  // namespace stylet::modeller
