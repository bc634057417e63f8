#include "render/classified.h"

#include <algorithm>
#include <array>
#include <thread>
#include <vector>

namespace stylet::render {
namespace {

using Plane = std::vector<glm::vec4>;

void classifyPlane(const patient::Package& package, const Palette& palette, int z, Plane& out) {
    const std::size_t at = package.ct.grid.offset({0, 0, z});
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = palette.at(package.ct.voxels[at + i], package.labels.voxels[at + i]);
}

// (1 2 1) / 4 along x, then y; the edge repeats.
void smoothPlane(Plane& plane, Plane& scratch, int width, int height) {
    for (int y = 0; y < height; ++y) {
        const glm::vec4* in = plane.data() + std::ptrdiff_t(y) * width;
        glm::vec4* out = scratch.data() + std::ptrdiff_t(y) * width;
        for (int x = 0; x < width; ++x)
            out[x] = 0.25f * (in[std::max(x - 1, 0)] + in[std::min(x + 1, width - 1)]) + 0.5f * in[x];
    }
    for (int y = 0; y < height; ++y) {
        const glm::vec4* above = scratch.data() + std::ptrdiff_t(std::max(y - 1, 0)) * width;
        const glm::vec4* here = scratch.data() + std::ptrdiff_t(y) * width;
        const glm::vec4* below = scratch.data() + std::ptrdiff_t(std::min(y + 1, height - 1)) * width;
        glm::vec4* out = plane.data() + std::ptrdiff_t(y) * width;
        for (int x = 0; x < width; ++x)
            out[x] = 0.25f * (above[x] + below[x]) + 0.5f * here[x];
    }
}

void storePlane(const Plane& below, const Plane& here, const Plane& above, std::byte* rgba) {
    for (std::size_t i = 0; i < here.size(); ++i) {
        const glm::vec4 texel = 255.0f * (0.25f * (below[i] + above[i]) + 0.5f * here[i]) + 0.5f;
        const bool clear = texel.a < 2.0f;
        for (int c = 0; c < 4; ++c)
            rgba[i * 4 + std::size_t(c)] =
                clear ? std::byte{0} : std::byte(std::uint8_t(std::min(texel[c], 255.0f)));
    }
}

void classifyRange(const patient::Patient& patient, const Palette& palette, int z0, int z1, std::byte* rgba) {
    const patient::Index3 dims = patient.grid().dims;
    const std::size_t texels = std::size_t(dims.x) * std::size_t(dims.y);
    std::array<Plane, 3> ring;  // planes z-1, z, z+1 at (z+2) % 3, z % 3, (z+1) % 3
    for (Plane& plane : ring)
        plane.resize(texels);
    Plane scratch(texels);
    const auto load = [&](int z) {
        Plane& plane = ring[std::size_t((z + 3) % 3)];
        classifyPlane(patient.package(), palette, std::clamp(z, 0, dims.z - 1), plane);
        smoothPlane(plane, scratch, dims.x, dims.y);
    };
    load(z0 - 1);
    load(z0);
    for (int z = z0; z < z1; ++z) {
        load(z + 1);
        storePlane(ring[std::size_t((z + 2) % 3)], ring[std::size_t(z % 3)], ring[std::size_t((z + 1) % 3)],
                   rgba + std::size_t(z - z0) * texels * 4);
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
