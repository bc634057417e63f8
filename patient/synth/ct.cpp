// Models partial volume: the ideal image is blurred by [1 2 1]/4 along each axis (FWHM 2 voxels), like a
// soft kernel at 1 mm. Thin structures lose contrast. The ideal values are then shifted label by label
// until the means of the blurred image match the table.
#include "patient/synth/ct.h"

#include <array>

#include "base/parallel.h"
#include "patient/synth/random.h"

namespace stylet::patient::synth {

namespace {

constexpr double kNoise_hu = 11.0;

void blur(std::vector<float>& image, const Canvas& canvas, int passes) {
    for (int pass = 0; pass < passes; ++pass)
        for (int axis = 0; axis < 3; ++axis)
            parallelLines(canvas.threads, canvas.grid().dims, axis, image.data(), smoothLine);
}

using Sums = std::array<double, std::size_t(kIdCount)>;

// Mean per label. Slices are summed in order, so that the thread count does not change the rounding.
Sums labelMeans(const std::vector<float>& image, const Canvas& canvas, const CtSettings& settings) {
    const Grid& grid = canvas.grid();
    std::vector<Sums> sums(std::size_t(grid.dims.z), Sums{}), counts(std::size_t(grid.dims.z), Sums{});
    parallelVoxels(canvas.threads, grid, [&](const Index3& i) {
        sums[std::size_t(i.z)][canvas.labels[i]] += double(image[grid.offset(i)]);
        counts[std::size_t(i.z)][canvas.labels[i]] += 1.0;
    });
    Sums mean{}, count{};
    for (std::size_t z = 0; z < sums.size(); ++z)
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += sums[z][i], count[i] += counts[z][i];
    for (std::size_t i = 0; i < mean.size(); ++i)
        mean[i] = count[i] > 0.0 ? mean[i] / count[i] : settings.mean_hu[i];
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

// Ideal values before the blur, from each label's row and the detail of its voxels.
std::vector<float> idealValues(const Canvas& canvas, std::uint64_t seed, const CtSettings& settings) {
    std::vector<float> ideal(canvas.grid().voxelCount());
    parallelVoxels(canvas.threads, canvas.grid(), [&](const Index3& i) {
        const std::size_t n = canvas.grid().offset(i);
        const std::uint8_t id = canvas.labels.voxels[n];
        const CtRow& row = ctRow(Id(id));
        double hu =
            row.low_hu + (row.high_hu - row.low_hu) * settings.contrast[id] * canvas.detail[n] / 255.0;
        if (row.texture_hu > 0.0) hu += row.texture_hu * valueNoise(canvas.at(i) / 4.5, seed ^ 0x71);
        ideal[n] = float(hu);
    });
    return ideal;
}

// The blurred image without noise, in which each label has its mean, and then the inclusions.
std::vector<float> blurredImage(const Canvas& canvas, std::uint64_t seed, const CtSettings& settings) {
    std::vector<float> ideal = idealValues(canvas, seed, settings), image = ideal;
    blur(image, canvas, settings.blur_passes);
    for (int round = 0; round < 3; ++round) {
        const Sums mean = labelMeans(image, canvas, settings);
        std::array<float, std::size_t(kIdCount)> shift{};
        for (std::size_t i = 1; i < shift.size(); ++i)
            shift[i] = float(settings.mean_hu[i] - mean[i]);
        for (std::size_t n = 0; n < ideal.size(); ++n)
            ideal[n] += shift[canvas.labels.voxels[n]];
        image = ideal;
        blur(image, canvas, settings.blur_passes);
    }
    if (settings.inclusions.empty()) return image;
    for (const Inclusion& inclusion : settings.inclusions)
        ideal[inclusion.voxel] = inclusion.hu;
    blur(ideal, canvas, settings.blur_passes);
    return ideal;
}

}  // namespace

CtSettings::CtSettings() {
    for (std::size_t i = 0; i < mean_hu.size(); ++i)
        mean_hu[i] = ctRow(Id(i)).mean_hu;
    contrast.fill(1.0);
}

CtVolume makeCt(const Canvas& canvas, std::uint64_t seed, const CtSettings& settings) {
    const Grid& grid = canvas.grid();
    const std::size_t plane = std::size_t(grid.dims.x) * std::size_t(grid.dims.y);
    const std::vector<float> image = blurredImage(canvas, seed, settings);
    const double noise_hu = kNoise_hu * settings.noise;

    // White noise, smoothed within the plane like the grain of a reconstruction and rescaled to the noise's
    // standard deviation.
    CtVolume ct(grid);
    parallelFor(canvas.threads, grid.dims.z, [&](int z) {
        const std::size_t first = std::size_t(z) * plane;
        std::vector<float> grain(plane);
        for (std::size_t i = 0; i < plane; ++i)
            grain[i] = gaussian(mixBits(seed ^ 0x72) + (first + i) * 0xd1342543de82ef95ull);
        for (const int axis : {0, 1})
            parallelLines(1, {grid.dims.x, grid.dims.y, 1}, axis, grain.data(), smoothLine);
        for (std::size_t i = 0; i < plane; ++i) {
            // [1 2 1]/4 leaves 3/8 of the variance per axis.
            const double hu = double(image[first + i]) + noise_hu * double(grain[i]) / 0.375;
            ct.voxels[first + i] = std::int16_t(std::floor(std::clamp(hu, -1024.0, 3000.0) + 0.5));
        }
    });
    return ct;
}

}  // namespace stylet::patient::synth
