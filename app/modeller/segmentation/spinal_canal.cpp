#include "app/modeller/segmentation/spinal_canal.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/bone_voxels.h"
#include "base/parallel.h"

namespace stylet::modeller {

namespace {

constexpr double kCanalReach_m = 0.016, kCanalRadius_m = 0.013;
constexpr std::int16_t kCanalLow_hu = -60, kCanalHigh_hu = 100;

// The voxels within the canal's reach in 16 directions of the axial plane, from inside to outside.
class CanalRays {
  public:
    explicit CanalRays(const Grid& g) {
        for (std::size_t k = 0; k < rays_.size(); ++k) {
            const double phi = double(k) * std::numbers::pi / 8.0;
            for (double r = g.spacing_m.x; r <= kCanalReach_m; r += g.spacing_m.x)
                rays_[k].push_back({int(std::lround(r * std::cos(phi) / g.spacing_m.x)),
                                    int(std::lround(r * std::sin(phi) / g.spacing_m.y)), 0});
        }
    }
    // The share of the directions that hit bone.
    double score(const Mask& bone, const Index3& at) const {
        int hits = 0;
        for (const std::vector<Index3>& ray : rays_)
            for (const Index3& step : ray) {
                const Index3 i = at + step;
                if (!bone.grid.contains(i)) break;
                if (bone[i]) {
                    ++hits;
                    break;
                }
            }
        return double(hits) / double(rays_.size());
    }

  private:
    std::array<std::vector<Index3>, 16> rays_;
};

// For each slice, the score of each column around the body's midline.
struct CanalScores {
    int x0 = 0, y0 = 0, nx = 0, ny = 0;
    std::vector<std::vector<float>> scores;  // [z][(y - y0) * nx + x - x0]
};

CanalScores scoreSlices(const CtVolume& ct, const Mask& bone, const VoxelBox& body) {
    const Grid& g = ct.grid;
    const int middle = (body.low.x + body.high.x) / 2;
    const int half = int(0.06 / g.spacing_m.x);
    CanalScores s;
    s.x0 = std::max(body.low.x, middle - half);
    s.nx = std::min(body.high.x, middle + half) - s.x0 + 1;
    s.y0 = body.low.y;
    s.ny = (body.high.y - body.low.y) * 6 / 10 + 1;
    s.scores.resize(std::size_t(g.dims.z));
    const FloatVolume smooth = boxMean(toFloat(ct), 1);
    const CanalRays rays(g);
    parallelFor(processorCount(), g.dims.z, [&](int z) {
        std::vector<float>& slice = s.scores[std::size_t(z)];
        slice.assign(std::size_t(s.nx * s.ny), 0.0f);
        for (int y = 0; y < s.ny; ++y)
            for (int x = 0; x < s.nx; ++x) {
                const Index3 i{s.x0 + x, s.y0 + y, z};
                const float hu = smooth[i];
                if (bone[i] || hu < kCanalLow_hu || hu > kCanalHigh_hu) continue;
                const double score = rays.score(bone, i);
                if (score > 0.6) slice[std::size_t(y * s.nx + x)] = float(score);
            }
    });
    return s;
}

// Finds the line with the best scores from feet to head, by dynamic programming over slices. The line is
// smooth: it drifts by at most one voxel per slice.
std::vector<Index3> canalLine(const CanalScores& s, int slices) {
    const int nx = s.nx, ny = s.ny;
    std::vector<float> sum(std::size_t(nx * ny), 0.0f), last;
    std::vector<std::vector<std::int8_t>> from(std::size_t(slices), std::vector<std::int8_t>(sum.size(), 4));
    constexpr float kDrift = 0.05f;
    for (int z = 0; z < slices; ++z) {
        last = sum;
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) {
                const std::size_t at = std::size_t(y * nx + x);
                float best = z == 0 ? 0.0f : last[at];
                std::int8_t step = 4;
                for (int k = 0; k < 9 && z > 0; ++k) {
                    const int xx = x + k % 3 - 1, yy = y + k / 3 - 1;
                    if (k == 4 || xx < 0 || yy < 0 || xx >= nx || yy >= ny) continue;
                    const float value = last[std::size_t(yy * nx + xx)] - kDrift;
                    if (value > best) best = value, step = std::int8_t(k);
                }
                sum[at] = best + s.scores[std::size_t(z)][at];
                from[std::size_t(z)][at] = step;
            }
    }
    const auto end = std::max_element(sum.begin(), sum.end());
    if (end == sum.end() || *end <= 0.0f) return {};
    int x = int((end - sum.begin()) % nx), y = int((end - sum.begin()) / nx);
    std::vector<Index3> line(std::size_t(slices), Index3(0));
    for (int z = slices - 1; z >= 0; --z) {
        line[std::size_t(z)] = {s.x0 + x, s.y0 + y, z};
        const int k = from[std::size_t(z)][std::size_t(y * nx + x)];
        x += k % 3 - 1;
        y += k / 3 - 1;
    }
    return line;
}

// Fills the soft region around the line that is enclosed by bone, slice by slice. In each slice with such a
// region, its centre is appended to `centres`.
Mask fillCanal(const CtVolume& ct, const Mask& bone, const std::vector<Index3>& line,
               std::vector<Vec3>& centres) {
    const Grid& g = ct.grid;
    const int reach = int(kCanalRadius_m / g.spacing_m.x);
    const CanalRays rays(g);
    Mask canal(g);
    for (const Index3& middle : line) {
        Vec3 sum(0.0);
        double count = 0.0;
        for (int dy = -reach; dy <= reach; ++dy)
            for (int dx = -reach; dx <= reach; ++dx) {
                const Index3 i = middle + Index3(dx, dy, 0);
                if (dx * dx + dy * dy > reach * reach || !g.contains(i) || bone[i]) continue;
                if (ct[i] < kCanalLow_hu - 60 || ct[i] > kBone_hu) continue;
                // Accept the voxel only if no bone lies between it and the centre.
                const int steps = std::max(std::abs(dx), std::abs(dy));
                bool visible = true;
                for (int k = 1; k < steps && visible; ++k)
                    visible = !bone[middle + Index3(dx * k / steps, dy * k / steps, 0)];
                if (!visible || rays.score(bone, i) < 0.65) continue;
                canal[i] = 1;
                sum += g.centre(i);
                count += 1.0;
            }
        if (count * g.spacing_m.x * g.spacing_m.y > 30e-6) centres.push_back(sum / count);
    }
    return opened(canal, 1.01 * g.spacing_m.x);
}

// Between the vertebral arches, extends the canal at its usual width.
void bridgeCanalGaps(const CtVolume& ct, const Mask& bone, const std::vector<Vec3>& centres, Mask& canal) {
    constexpr double kAside_m = 0.0095, kDeep_m = 0.0075, kGap_m = 0.040;
    const Grid& g = ct.grid;
    for (std::size_t n = 0; n + 1 < centres.size(); ++n) {
        const Vec3 a = centres[n], b = centres[n + 1];
        if (b.z - a.z > kGap_m) continue;
        const int first = g.nearest(a).z, last = g.nearest(b).z;
        for (int z = first; z <= last; ++z) {
            const double share = last > first ? double(z - first) / double(last - first) : 0.0;
            const Vec3 middle = a + share * (b - a);
            forEachVoxel(VoxelBox{{0, 0, z}, {g.dims.x - 1, g.dims.y - 1, z}}, [&](const Index3& i) {
                const Vec3 d = g.centre(i) - middle;
                const double u = d.x / kAside_m, v = d.y / kDeep_m;
                if (u * u + v * v < 1.0 && !bone[i] && ct[i] > 2 * kCanalLow_hu && ct[i] < kBone_hu)
                    canal[i] = 1;
            });
        }
    }
}

}  // namespace

SpinalCanal findCanal(const CtVolume& ct, const Mask& shell, const VoxelBox& body) {
    const Mask tight = closed(shell, std::max(0.002, ct.grid.spacing_m.x));
    const std::vector<Index3> line = canalLine(scoreSlices(ct, tight, body), ct.grid.dims.z);
    SpinalCanal canal;
    canal.voxels = fillCanal(ct, tight, line, canal.centres_m);
    bridgeCanalGaps(ct, shell, canal.centres_m, canal.voxels);
    return canal;
}

}  // namespace stylet::modeller
