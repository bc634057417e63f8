#include "base/distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace stylet {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();

// Squared distances along one line, by the lower envelope of parabolas rooted at the finite values of f.
class LineTransform {
  public:
    LineTransform(int length, double spacing_m)
        : spacing_m_(spacing_m), f_(std::size_t(length)), roots_(f_.size()), starts_(f_.size() + 1) {}

    // Transforms every `stride`-th value from `first` in place.
    void apply(float* first, std::size_t stride) {
        for (std::size_t i = 0; i < f_.size(); ++i)
            f_[i] = first[i * stride];
        const std::size_t count = buildEnvelope();
        if (count == 0) return;
        std::size_t k = 0;
        for (std::size_t i = 0; i < f_.size(); ++i) {
            while (k + 1 < count && starts_[k + 1] < double(i))
                ++k;
            const double d_m = (double(i) - double(roots_[k])) * spacing_m_;
            first[i * stride] = float(d_m * d_m + double(f_[roots_[k]]));
        }
    }

  private:
    // Position where the parabola of q falls below that of p < q, in voxels.
    double crossing(std::size_t p, std::size_t q) const {
        const double lift = (double(f_[q]) - double(f_[p])) / (spacing_m_ * spacing_m_);
        return 0.5 * (lift / double(q - p) + double(q + p));
    }
    std::size_t buildEnvelope() {
        std::size_t count = 0;
        for (std::size_t q = 0; q < f_.size(); ++q) {
            if (f_[q] == kNone) continue;
            double start = -std::numeric_limits<double>::infinity();
            while (count > 0 && (start = crossing(roots_[count - 1], q)) <= starts_[count - 1])
                --count;
            starts_[count] = count == 0 ? -std::numeric_limits<double>::infinity() : start;
            roots_[count++] = q;
        }
        return count;
    }

    double spacing_m_;
    std::vector<float> f_;
    std::vector<std::size_t> roots_;
    std::vector<double> starts_;
};

void distancesFromAbove(float* bottom, std::size_t stride, int length, double spacing_m) {
    float above = kNone;
    for (int z = length - 1; z >= 0; --z) {
        float& f = bottom[std::size_t(z) * stride];
        above = f == 0.0f ? 0.0f : above + float(spacing_m);
        f = above * above;
    }
}

}  // namespace

Volume<float> distanceTo(const Volume<std::uint8_t>& mask, Sites sites, int threads) {
    const Grid& grid = mask.grid;
    Volume<float> out(grid);
    std::transform(mask.voxels.begin(), mask.voxels.end(), out.voxels.begin(),
                   [](std::uint8_t m) { return m ? 0.0f : kNone; });
    const std::size_t nx = std::size_t(grid.dims.x), ny = std::size_t(grid.dims.y),
                      nz = std::size_t(grid.dims.z);
    parallelFor(threads, ny, [&](std::size_t y) {
        LineTransform line(grid.dims.z, grid.spacing_m.z);
        for (std::size_t x = 0; x < nx; ++x) {
            float* const column = out.voxels.data() + y * nx + x;
            if (sites == Sites::above)
                distancesFromAbove(column, nx * ny, grid.dims.z, grid.spacing_m.z);
            else
                line.apply(column, nx * ny);
        }
    });
    parallelFor(threads, nz, [&](std::size_t z) {
        float* const slice = out.voxels.data() + z * nx * ny;
        LineTransform along_y(grid.dims.y, grid.spacing_m.y), along_x(grid.dims.x, grid.spacing_m.x);
        for (std::size_t x = 0; x < nx; ++x)
            along_y.apply(slice + x, nx);
        for (std::size_t y = 0; y < ny; ++y)
            along_x.apply(slice + y * nx, 1);
        for (std::size_t i = 0; i < nx * ny; ++i)
            slice[i] = std::sqrt(slice[i]);
    });
    return out;
}

double sampleTrilinear(const Volume<float>& volume, const Vec3& p) noexcept {
    const Vec3 v = glm::clamp(volume.grid.toVoxels(p), Vec3(0.0), Vec3(volume.grid.dims - 1));
    const Index3 low = glm::min(Index3(v), volume.grid.dims - 1);
    const Index3 high = glm::min(low + 1, volume.grid.dims - 1);
    const Vec3 s = v - Vec3(low);
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1.0;
        Index3 at;
        for (int axis = 0; axis < 3; ++axis) {
            const bool up = corner >> axis & 1;
            weight *= up ? s[axis] : 1.0 - s[axis];
            at[axis] = up ? high[axis] : low[axis];
        }
        if (weight > 0.0) sum += weight * double(volume[at]);
    }
    return sum;
}

}  // namespace stylet
