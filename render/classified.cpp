#include "render/classified.h"

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

namespace stylet::render {
namespace {

using Plane = std::vector<glm::vec4>;

bool onBorder(const patient::LabelVolume& labels, const Palette& palette, const patient::Index3& at,
              std::uint8_t id) {
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
            patient::Index3 beside = at;
            beside[axis] += side;
            if (labels.grid.contains(beside) && palette.borders(id, labels[beside])) return true;
        }
    return false;
}

void classifyPlane(const patient::Package& package, const Palette& palette, int z, Plane& out) {
    const patient::Index3 dims = package.ct.grid.dims;
    std::size_t i = 0;
    for (int y = 0; y < dims.y; ++y)
        for (int x = 0; x < dims.x; ++x, ++i) {
            const patient::Index3 at(x, y, z);
            const std::uint8_t id = package.labels[at];
            const bool shell = palette.shell[id] && onBorder(package.labels, palette, at, id);
            out[i] = shell ? *palette.shell[id] : palette.at(package.ct[at], id);
        }
}

// Row 2r of Pascal's triangle over 4^r: the binomial filter of radius r.
std::vector<float> binomial(int radius) {
    std::vector<float> weights{1.0f};
    for (int i = 0; i < 2 * radius; ++i) {
        weights.push_back(0.0f);
        for (std::size_t k = weights.size() - 1; k > 0; --k)
            weights[k] = 0.5f * (weights[k] + weights[k - 1]);
        weights[0] *= 0.5f;
    }
    return weights;
}

// Along x, then y; the edge repeats.
void smoothPlane(Plane& plane, Plane& scratch, int width, int height, const std::vector<float>& weights) {
    const int radius = int(weights.size()) / 2;
    for (int y = 0; y < height; ++y) {
        const glm::vec4* in = plane.data() + std::ptrdiff_t(y) * width;
        glm::vec4* out = scratch.data() + std::ptrdiff_t(y) * width;
        for (int x = 0; x < width; ++x) {
            glm::vec4 sum(0.0f);
            for (int k = -radius; k <= radius; ++k)
                sum += weights[std::size_t(k + radius)] * in[std::clamp(x + k, 0, width - 1)];
            out[x] = sum;
        }
    }
    std::fill(plane.begin(), plane.end(), glm::vec4(0.0f));
    for (int y = 0; y < height; ++y) {
        glm::vec4* out = plane.data() + std::ptrdiff_t(y) * width;
        for (int k = -radius; k <= radius; ++k) {
            const glm::vec4* in = scratch.data() + std::ptrdiff_t(std::clamp(y + k, 0, height - 1)) * width;
            const float weight = weights[std::size_t(k + radius)];
            for (int x = 0; x < width; ++x)
                out[x] += weight * in[x];
        }
    }
}

void storePlane(const Plane& plane, const Palette& palette, std::byte* rgba) {
    const float low = palette.edge_low, stretch = 1.0f / (palette.edge_high - palette.edge_low);
    for (std::size_t i = 0; i < plane.size(); ++i) {
        const float opacity = std::clamp((plane[i].a - low) * stretch, 0.0f, 1.0f);
        const float weight = plane[i].a > 0.0f ? opacity / plane[i].a : 0.0f;
        const glm::vec4 texel = 255.0f * weight * plane[i] + 0.5f;
        const bool clear = texel.a < 2.0f;
        for (int c = 0; c < 4; ++c)
            rgba[i * 4 + std::size_t(c)] =
                clear ? std::byte{0} : std::byte(std::uint8_t(std::min(texel[c], 255.0f)));
    }
}

void classifyRange(const patient::Patient& patient, const Palette& palette, int z0, int z1, std::byte* rgba) {
    const patient::Index3 dims = patient.grid().dims;
    const std::size_t texels = std::size_t(dims.x) * std::size_t(dims.y);
    const std::vector<float> weights = binomial(palette.smoothing_voxels);
    const int radius = palette.smoothing_voxels, span = 2 * radius + 1;
    std::vector<Plane> ring{std::size_t(span), Plane(texels)};  // plane z at (z + radius) % span
    Plane scratch(texels), sum(texels);
    const auto slot = [&](int z) -> Plane& { return ring[std::size_t((z + radius) % span)]; };
    const auto load = [&](int z) {
        classifyPlane(patient.package(), palette, std::clamp(z, 0, dims.z - 1), slot(z));
        smoothPlane(slot(z), scratch, dims.x, dims.y, weights);
    };
    for (int z = z0 - radius; z < z0 + radius; ++z)
        load(z);
    for (int z = z0; z < z1; ++z) {
        load(z + radius);
        std::fill(sum.begin(), sum.end(), glm::vec4(0.0f));
        for (int k = -radius; k <= radius; ++k) {
            const Plane& plane = slot(z + k);
            const float weight = weights[std::size_t(k + radius)];
            for (std::size_t i = 0; i < texels; ++i)
                sum[i] += weight * plane[i];
        }
        storePlane(sum, palette, rgba + std::size_t(z - z0) * texels * 4);
    }
}

}  // namespace

void classifyPlanes(const patient::Patient& patient, const Palette& palette, int z0, int z1, std::byte* rgba,
                    int threads) {
    const patient::Index3 dims = patient.grid().dims;
    const std::size_t plane_bytes = std::size_t(dims.x) * std::size_t(dims.y) * 4;
    std::vector<std::jthread> workers;
    for (int i = 0; i < threads; ++i) {
        const int from = z0 + (z1 - z0) * i / threads, to = z0 + (z1 - z0) * (i + 1) / threads;
        if (from == to) continue;
        std::byte* out = rgba + std::size_t(from - z0) * plane_bytes;
        workers.emplace_back(
            [&patient, &palette, from, to, out] { classifyRange(patient, palette, from, to, out); });
    }
}

}  // namespace stylet::render
