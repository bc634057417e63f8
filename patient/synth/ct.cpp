// Models partial volume: the ideal image is blurred by [1 2 1]/4 along each axis (FWHM 2 voxels), like a
// soft kernel at 1 mm. Thin structures lose contrast. The ideal values are then shifted label by label
// until the means of the blurred image match the table.
#include "patient/synth/ct.h"

#include <array>

#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

constexpr double kNoise_hu = 11.0;

void blurRow(const float* in, float* out, std::size_t n, std::size_t stride) {
    for (std::size_t i = 0; i < n; ++i) {
        const float here = in[i * stride];
        const float before = i > 0 ? in[(i - 1) * stride] : here;
        const float after = i + 1 < n ? in[(i + 1) * stride] : here;
        out[i * stride] = 0.25f * before + 0.5f * here + 0.25f * after;
    }
}

// Within planes first, then across them.
void blur(std::vector<float>& image, std::vector<float>& work, const Grid& grid, int threads) {
    const auto nx = std::size_t(grid.dims.x), ny = std::size_t(grid.dims.y), plane = nx * ny;
    forSlices(threads, 0, grid.dims.z, [&](int z) {
        float* in = image.data() + std::size_t(z) * plane;
        float* out = work.data() + std::size_t(z) * plane;
        for (std::size_t y = 0; y < ny; ++y)
            blurRow(in + y * nx, out + y * nx, nx, 1);
        for (std::size_t y = 0; y < ny; ++y) {
            const float* here = out + y * nx;
            const float* before = y > 0 ? here - nx : here;
            const float* after = y + 1 < ny ? here + nx : here;
            for (std::size_t x = 0; x < nx; ++x)
                in[y * nx + x] = 0.25f * before[x] + 0.5f * here[x] + 0.25f * after[x];
        }
    });
    forSlices(threads, 0, grid.dims.z, [&](int z) {
        const float* here = image.data() + std::size_t(z) * plane;
        const float* before = z > 0 ? here - plane : here;
        const float* after = z + 1 < grid.dims.z ? here + plane : here;
        float* out = work.data() + std::size_t(z) * plane;
        for (std::size_t i = 0; i < plane; ++i)
            out[i] = 0.25f * before[i] + 0.5f * here[i] + 0.25f * after[i];
    });
    image.swap(work);
}

using Sums = std::array<double, std::size_t(kIdCount)>;

// Mean per label. Slices are summed in order, so that the thread count does not change the rounding.
Sums labelMeans(const std::vector<float>& image, const Canvas& canvas) {
    const Grid& grid = canvas.grid();
    const std::size_t plane = std::size_t(grid.dims.x) * std::size_t(grid.dims.y);
    std::vector<Sums> sums(std::size_t(grid.dims.z), Sums{}), counts(std::size_t(grid.dims.z), Sums{});
    forSlices(canvas.threads, 0, grid.dims.z, [&](int z) {
        for (std::size_t n = std::size_t(z) * plane; n < std::size_t(z + 1) * plane; ++n) {
            sums[std::size_t(z)][canvas.labels.voxels[n]] += double(image[n]);
            counts[std::size_t(z)][canvas.labels.voxels[n]] += 1.0;
        }
    });
    Sums mean{}, count{};
    for (std::size_t z = 0; z < sums.size(); ++z)
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += sums[z][i], count[i] += counts[z][i];
    for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] = count[i] > 0.0 ? mean[i] / count[i] : ctRow(Id(i)).mean_hu;
    return mean;
}

// Approximately Gaussian with unit variance: the sum of eight 16-bit uniforms from the voxel's hash.
float gaussian(std::uint64_t key) {
    std::int64_t sum = 0;
    for (int half = 0; half < 2; ++half) {
        const std::uint64_t h = mixBits(key + std::uint64_t(half) * 0x632be59bd9b4e019ull);
        for (int k = 0; k < 4; ++k)
            sum += std::int64_t(h >> (16 * k) & 0xffffu);
    }
    // Mean 8 * 65535 / 2, variance 8 * (65536^2 - 1) / 12.
    return float(double(sum - 262140) * 1.8688e-5);
}

}  // namespace

CtVolume makeCt(const Canvas& canvas, std::uint64_t seed) {
    const Grid& grid = canvas.grid();
    const std::size_t plane = std::size_t(grid.dims.x) * std::size_t(grid.dims.y);
    std::vector<float> ideal(grid.voxelCount()), image, work(grid.voxelCount());
    forSlices(canvas.threads, 0, grid.dims.z, [&](int z) {
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x) {
                const std::size_t n = grid.offset({x, y, z});
                const CtRow& row = ctRow(Id(canvas.labels.voxels[n]));
                double hu = row.low_hu + (row.high_hu - row.low_hu) * canvas.detail[n] / 255.0;
                if (row.texture_hu > 0.0)
                    hu += row.texture_hu * valueNoise(canvas.at({x, y, z}) / 4.5, seed ^ 0x71);
                ideal[n] = float(hu);
            }
    });
    image = ideal;
    blur(image, work, grid, canvas.threads);
    for (int round = 0; round < 3; ++round) {
        const Sums mean = labelMeans(image, canvas);
        std::array<float, std::size_t(kIdCount)> shift{};
        for (int i = 1; i < kIdCount; ++i)
            shift[std::size_t(i)] = float(ctRow(Id(i)).mean_hu - mean[std::size_t(i)]);
        for (std::size_t n = 0; n < ideal.size(); ++n)
            ideal[n] += shift[canvas.labels.voxels[n]];
        image = ideal;
        blur(image, work, grid, canvas.threads);
    }
    ideal.clear();
    ideal.shrink_to_fit();

    // Noise with the grain of a reconstruction: white noise smoothed within the plane and rescaled to its
    // standard deviation.
    CtVolume ct(grid);
    forSlices(canvas.threads, 0, grid.dims.z, [&](int z) {
        const auto nx = std::size_t(grid.dims.x), ny = std::size_t(grid.dims.y);
        std::vector<float> white(plane), smooth(plane);
        for (std::size_t i = 0; i < plane; ++i)
            white[i] =
                gaussian(mixBits(seed ^ 0x72) + (std::uint64_t(z) * plane + i) * 0xd1342543de82ef95ull);
        for (std::size_t y = 0; y < ny; ++y)
            blurRow(white.data() + y * nx, smooth.data() + y * nx, nx, 1);
        for (std::size_t y = 0; y < ny; ++y)
            for (std::size_t x = 0; x < nx; ++x) {
                const std::size_t i = y * nx + x;
                const float before = smooth[y > 0 ? i - nx : i], after = smooth[y + 1 < ny ? i + nx : i];
                const float grain = 0.25f * before + 0.5f * smooth[i] + 0.25f * after;
                // [1 2 1]/4 leaves 3/8 of the variance per axis.
                const double hu =
                    double(image[std::size_t(z) * plane + i]) + kNoise_hu * double(grain) / 0.375;
                ct.voxels[std::size_t(z) * plane + i] =
                    std::int16_t(std::floor(std::clamp(hu, -1024.0, 3000.0) + 0.5));
            }
    });
    return ct;
}

}  // namespace stylet::patient::synth
