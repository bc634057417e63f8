#include "app/modeller/image/scan_blur.h"

#include <algorithm>
#include <cmath>

namespace stylet::modeller {

namespace {

// In voxels from the edge: where a profile begins, where clear air begins and the fit ends, where it ends.
constexpr int kInside = 3, kAir = 4, kOutside = 7;
constexpr int kAside = 2;  // to the neighbours that show the slope of the skin
constexpr double kSteepestSkin = 0.25;
constexpr double kMinSkin_hu = -500.0, kClearAir_hu = -900.0;

// Where the values along a line from inside the body to the front reach halfway from skin to air.
struct SkinEdge {
    int last = 0;     // the last voxel above halfway
    double at = 0.0;  // in voxels
    double skin_hu = 0.0, air_hu = 0.0;
};

std::optional<SkinEdge> findEdge(const CtVolume& ct, int x, int z) {
    const int end = ct.grid.dims.y, middle = end / 2;
    int y = end - 1;
    while (y > middle && ct[{x, y, z}] <= kMinSkin_hu)
        --y;
    if (y - kInside < middle || y + kOutside >= end) return std::nullopt;
    SkinEdge edge;
    edge.skin_hu = ct[{x, y, z}];
    for (int k = 1; k < kInside; ++k)
        edge.skin_hu = std::max(edge.skin_hu, double(ct[{x, y - k, z}]));
    for (int k = kAir; k < kOutside; ++k)
        edge.air_hu += ct[{x, y + k, z}] / double(kOutside - kAir);
    if (edge.air_hu > kClearAir_hu) return std::nullopt;
    const double half_hu = 0.5 * (edge.skin_hu + edge.air_hu);
    while (ct[{x, y, z}] < half_hu)  // ends at the voxel of skin_hu at the latest
        --y;
    while (ct[{x, y + 1, z}] > half_hu)
        ++y;
    edge.last = y;
    edge.at = y + (ct[{x, y, z}] - half_hu) / double(ct[{x, y, z}] - ct[{x, y + 1, z}]);
    return edge;
}

// Distance from the edge in voxels, and the share of skin there.
struct EdgeSample {
    double distance, skin;
};

std::vector<EdgeSample> sampleEdges(const CtVolume& ct) {
    std::vector<EdgeSample> samples;
    const Index3 dims = ct.grid.dims;
    for (int z = kAside; z < dims.z - kAside; z += 2)
        for (int x = kAside; x < dims.x - kAside; x += 2) {
            const auto edge = findEdge(ct, x, z), left = findEdge(ct, x - kAside, z),
                       right = findEdge(ct, x + kAside, z), below = findEdge(ct, x, z - kAside),
                       above = findEdge(ct, x, z + kAside);
            if (!edge || !left || !right || !below || !above) continue;
            const double slope =
                std::max(std::fabs(left->at - right->at), std::fabs(below->at - above->at)) / (2.0 * kAside);
            if (slope > kSteepestSkin) continue;
            for (int y = edge->last; y < edge->last + kAir; ++y)
                samples.push_back(
                    {y - edge->at, (ct[{x, y, z}] - edge->air_hu) / (edge->skin_hu - edge->air_hu)});
        }
    return samples;
}

// The median deviation of the samples from an edge with this blur, in voxels. A minority of samples, at folds
// and cables for instance, does not matter.
double deviation(const std::vector<EdgeSample>& samples, double blur) {
    std::vector<double> apart(samples.size());
    std::transform(samples.begin(), samples.end(), apart.begin(), [&](const EdgeSample& s) {
        return std::fabs(s.skin - 0.5 * std::erfc(s.distance / (blur * std::sqrt(2.0))));
    });
    const auto middle = apart.begin() + std::ptrdiff_t(apart.size() / 2);
    std::nth_element(apart.begin(), middle, apart.end());
    return *middle;
}

}  // namespace

std::optional<double> measureBlur(const CtVolume& ct) {
    constexpr double kSharpest = 0.1, kSoftest = 3.0, kStep = 0.02;  // voxels
    constexpr double kSharpestScan = 0.3;                            // sharper: somebody has cut the air away
    constexpr std::size_t kMinSamples = 400;
    const std::vector<EdgeSample> samples = sampleEdges(ct);
    if (samples.size() < kMinSamples) return std::nullopt;
    double best = 0.0, least = 1.0;
    for (double blur = kSharpest; blur < kSoftest; blur += kStep)
        if (const double d = deviation(samples, blur); d < least) least = d, best = blur;
    if (best < kSharpestScan) return std::nullopt;
    return best * ct.grid.spacing_m.y;
}

}  // namespace stylet::modeller
