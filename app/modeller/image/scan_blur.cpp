#include "app/modeller/image/scan_blur.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>

namespace stylet::modeller {

namespace {

// In voxels from the edge: where clear air begins, and where it ends.
constexpr int kAir = 4, kOutside = 7;
constexpr int kAside = 2;  // to the neighbours that show the slope of the edge
constexpr double kSteepest = 0.25;
constexpr double kMinDense_hu = -500.0;

// The values along a line of voxels, parallel to an axis.
struct Line {
    const CtVolume& ct;
    Index3 first;
    int axis;
    int size() const { return ct.grid.dims[axis]; }
    double operator[](int at) const {
        Index3 i = first;
        i[axis] = at;
        return ct[i];
    }
    double mean(int from, int to) const {
        double sum = 0.0;
        for (int k = from; k < to; ++k)
            sum += (*this)[k];
        return sum / (to - from);
    }
};

// Where the values along a line reach halfway from dense to air.
struct Edge {
    int last = 0;     // the last voxel above halfway
    double at = 0.0;  // in voxels
    double dense_hu = 0.0, air_hu = 0.0;
};

// `near` is a voxel above halfway, beyond which the values fall.
Edge halfway(const Line& line, int near, double dense_hu, double air_hu) {
    const double half_hu = 0.5 * (dense_hu + air_hu);
    int k = near;
    while (line[k + 1] > half_hu)
        ++k;
    return {k, k + (line[k] - half_hu) / (line[k] - line[k + 1]), dense_hu, air_hu};
}

// The front of the body. Skin is thin: its value is that of its brightest voxel.
std::optional<Edge> findSkin(const Line& line) {
    constexpr int kInside = 3;
    constexpr double kClearAir_hu = -900.0;
    const int end = line.size(), middle = end / 2;
    int y = end - 1;
    while (y > middle && line[y] <= kMinDense_hu)
        --y;
    if (y - kInside < middle || y + kOutside >= end) return std::nullopt;
    int skin = y;
    for (int k = 1; k < kInside; ++k)
        if (line[y - k] > line[skin]) skin = y - k;
    const double air_hu = line.mean(y + kAir, y + kOutside);
    if (air_hu > kClearAir_hu) return std::nullopt;
    return halfway(line, skin, line[skin], air_hu);
}

// The lowest place where lung lies on tissue: diaphragm with liver or spleen under it.
std::optional<Edge> findLungBase(const Line& line) {
    constexpr int kClear = 4, kTissue = 12;  // in voxels below the edge: where clear tissue begins and ends
    constexpr double kMinTissue_hu = 0.0, kMaxTissue_hu = 250.0, kMinLung_hu = -950.0, kMaxLung_hu = -700.0;
    for (int z = kTissue; z + kOutside < line.size(); ++z) {
        if (line[z] <= kMinDense_hu || line[z + 1] > kMinDense_hu) continue;
        bool clear = true;
        for (int k = kClear; k < kTissue && clear; ++k)
            clear = line[z - k] > kMinTissue_hu && line[z - k] < kMaxTissue_hu;
        for (int k = 1; k <= kOutside && clear; ++k)
            clear = line[z + k] <= kMinDense_hu;
        if (!clear) continue;
        const double lung_hu = line.mean(z + kAir, z + kOutside);
        if (lung_hu < kMinLung_hu || lung_hu > kMaxLung_hu) return std::nullopt;
        return halfway(line, z - kClear, line.mean(z - kTissue + 1, z - kClear + 1), lung_hu);
    }
    return std::nullopt;
}

// Distance from the edge in voxels, and the share of dense tissue there.
struct EdgeSample {
    double distance, dense;
};

// Samples the edges that `find` finds along an axis, from `inside` voxels within the edge.
template <typename Find>
std::vector<EdgeSample> sampleEdges(const CtVolume& ct, int axis, int inside, Find&& find) {
    std::vector<EdgeSample> samples;
    const Index3 dims = ct.grid.dims;
    const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
    Index3 i(0);
    const auto edgeAside = [&](int aside_u, int aside_v) {
        Line line{ct, i, axis};
        line.first[u] += aside_u, line.first[v] += aside_v;
        return find(line);
    };
    for (i[v] = kAside; i[v] < dims[v] - kAside; i[v] += 2)
        for (i[u] = kAside; i[u] < dims[u] - kAside; i[u] += 2) {
            const std::optional<Edge> edge = edgeAside(0, 0);
            if (!edge) continue;
            const auto before = edgeAside(-kAside, 0), after = edgeAside(kAside, 0),
                       below = edgeAside(0, -kAside), above = edgeAside(0, kAside);
            if (!before || !after || !below || !above) continue;
            const double slope =
                std::max(std::fabs(before->at - after->at), std::fabs(below->at - above->at)) /
                (2.0 * kAside);
            if (slope > kSteepest) continue;
            const Line line{ct, i, axis};
            for (int k = edge->last - inside; k < edge->last + kAir; ++k)
                samples.push_back({k - edge->at, (line[k] - edge->air_hu) / (edge->dense_hu - edge->air_hu)});
        }
    return samples;
}

// The median deviation of the samples from an edge with this blur, in voxels. A minority of samples, at folds
// and cables for instance, does not matter.
double deviation(const std::vector<EdgeSample>& samples, double blur) {
    std::vector<double> apart(samples.size());
    std::transform(samples.begin(), samples.end(), apart.begin(), [&](const EdgeSample& s) {
        return std::fabs(s.dense - 0.5 * std::erfc(s.distance / (blur * std::sqrt(2.0))));
    });
    const auto middle = apart.begin() + std::ptrdiff_t(apart.size() / 2);
    std::nth_element(apart.begin(), middle, apart.end());
    return *middle;
}

// In voxels. None if there are too few samples.
std::optional<double> fitBlur(const std::vector<EdgeSample>& samples) {
    constexpr double kSharpest = 0.1, kSoftest = 3.0, kStep = 0.02;
    constexpr std::size_t kMinSamples = 400;
    if (samples.size() < kMinSamples) return std::nullopt;
    double best = 0.0, least = 1.0;
    for (double blur = kSharpest; blur < kSoftest; blur += kStep)
        if (const double d = deviation(samples, blur); d < least) least = d, best = blur;
    return best;
}

}  // namespace

std::optional<double> measureBlurWithin(const CtVolume& ct) {
    constexpr double kSharpestScan = 0.3;  // voxels; sharper: somebody has cut the air away
    const std::optional<double> blur = fitBlur(sampleEdges(ct, 1, 0, findSkin));
    if (!blur || *blur < kSharpestScan) return std::nullopt;
    return *blur * ct.grid.spacing_m.y;
}

std::optional<double> measureBlurAcross(const CtVolume& ct) {
    constexpr int kInside = 2;
    const std::optional<double> blur = fitBlur(sampleEdges(ct, 2, kInside, findLungBase));
    if (!blur) return std::nullopt;
    return *blur * ct.grid.spacing_m.z;
}

ScanBlur measureBlur(const CtVolume& ct) {
    const std::optional<double> within_m = measureBlurWithin(ct), across_m = measureBlurAcross(ct);
    ScanBlur blur;
    blur.within_m = within_m.value_or(kUsualBlur_m);
    blur.across_m = across_m.value_or(blur.within_m);
    blur.within_assumed = !within_m, blur.across_assumed = !across_m;
    return blur;
}

std::string blurText(const ScanBlur& blur) {
    return fmt::format("blur: {:.2f} mm within slices{}, {:.2f} mm across{}", 1e3 * blur.within_m,
                       blur.within_assumed ? " (assumed)" : "", 1e3 * blur.across_m,
                       blur.across_assumed ? " (assumed)" : "");
}

}  // namespace stylet::modeller
