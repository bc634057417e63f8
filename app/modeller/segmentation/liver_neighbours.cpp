#include "app/modeller/segmentation/liver_neighbours.h"

#include <algorithm>
#include <cmath>

#include "app/modeller/segmentation/morphology.h"

namespace stylet::modeller {

namespace {

// Minimum share of a lump's free border that ends in similar tissue, and minimum size of a lump.
constexpr double kEndless = 0.06, kLeastLump_ml = 1.0;
constexpr double kApart_voxels = 1.5;  // half the width of a connection that is cut between two lumps

// Calls visit(offset, voxel, face neighbour) for each voxel of the mask. The neighbour may be outside the
// grid.
template <typename Visit>
void forEachFace(const Mask& mask, const Visit& visit) {
    const Grid& g = mask.grid;
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 at{x, y, z};
                if (!mask[at]) continue;
                for (const Index3& step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}}) {
                    visit(g.offset(at), at, at - step);
                    visit(g.offset(at), at, at + step);
                }
            }
}

// Finds and numbers the lumps that the ball does not reach.
Volume<std::int32_t> lumpsBeyond(const Mask& liver, double radius_m, int& count) {
    Mask thick = eroded(liver, radius_m);
    keepLargest(thick);
    const Mask beyond = without(liver, dilated(thick, radius_m));
    const double apart_m = kApart_voxels * liver.grid.spacing_m.x;
    Pieces lumps = piecesOf(eroded(beyond, apart_m));
    count = lumps.count();
    // Grow the lumps back to full size: each voxel joins its nearest lump.
    for (int step = 0; step < 2; ++step) {
        const auto before = lumps.number;
        forEachFace(beyond, [&](std::size_t i, const Index3&, const Index3& next) {
            if (lumps.number.voxels[i] == 0)
                lumps.number.voxels[i] = before.grid.contains(next) ? before[next] : 0;
        });
    }
    return lumps.number;
}

}  // namespace

FloatVolume sigmaFiltered(const FloatVolume& image, const Mask& within, float alike, int reach) {
    const Grid& g = image.grid;
    FloatVolume out = image;
    forEachSlab(g.dims.z, [&](int z) {
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 at{x, y, z};
                if (!within[at]) continue;
                const Index3 low = glm::max(at - reach, Index3(0)), high = glm::min(at + reach, g.dims - 1);
                const float middle = image[at];
                float sum = 0.0f, count = 0.0f;
                for (int k = low.z; k <= high.z; ++k)
                    for (int j = low.y; j <= high.y; ++j)
                        for (int i = low.x; i <= high.x; ++i) {
                            const std::size_t o = g.offset({i, j, k});
                            if (!within.voxels[o] || std::abs(image.voxels[o] - middle) > alike) continue;
                            sum += image.voxels[o], count += 1.0f;
                        }
                out[at] = sum / count;
            }
    });
    return out;
}

FloatVolume levelled(const FloatVolume& hu, const Mask& core, float mean_hu, int reach) {
    FloatVolume more(hu.grid), count(hu.grid);
    for (std::size_t i = 0; i < hu.voxels.size(); ++i)
        if (core.voxels[i]) more.voxels[i] = hu.voxels[i] - mean_hu, count.voxels[i] = 1.0f;
    more = boxMean(boxMean(more, reach), reach);
    count = boxMean(boxMean(count, reach), reach);
    // Below this share of liver in the surroundings, the local level is uncertain and has less weight.
    constexpr float kEnough = 0.02f;
    FloatVolume out = hu;
    for (std::size_t i = 0; i < out.voxels.size(); ++i)
        out.voxels[i] -= more.voxels[i] / (count.voxels[i] + kEnough);
    return out;
}

Mask endlessLumps(const Mask& liver, const Mask& alike, double radius_m) {
    int count = 0;
    const auto number = lumpsBeyond(liver, radius_m, count);
    const auto is_alike = [&](const Index3& i) { return alike.grid.contains(i) && alike[i]; };
    std::vector<double> size(std::size_t(count) + 1, 0.0), ends = size, endless = size;
    for (const std::int32_t n : number.voxels)
        size[std::size_t(n)] += voxelVolume_ml(liver.grid);
    forEachFace(liver, [&](std::size_t i, const Index3& at, const Index3& next) {
        if (!liver.grid.contains(next) || liver[next]) return;
        const auto n = std::size_t(number.voxels[i]);
        ends[n] += 1.0;
        endless[n] += is_alike(next) && is_alike(next + next - at);
    });
    Mask out(liver.grid);
    for (std::size_t i = 0; i < out.voxels.size(); ++i) {
        const auto n = std::size_t(number.voxels[i]);
        out.voxels[i] = n > 0 && size[n] > kLeastLump_ml && endless[n] > kEndless * ends[n];
    }
    return out;
}

}  // namespace stylet::modeller
