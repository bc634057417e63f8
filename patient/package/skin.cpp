#include "patient/package/skin.h"

#include <algorithm>
#include <cmath>

#include "base/distance.h"
#include "base/geodesic.h"
#include "base/parallel.h"
#include "base/spline.h"

namespace stylet::patient {
namespace {

constexpr int kSmoothingPasses = 8;  // binomial passes, each with a variance of half a squared node spacing
constexpr int kNewtonSteps = 3;

// Mask of voxels that may be outer air: unlabelled voxels with the CT value of air. Labelled air is lung or
// gas.
Volume<std::uint8_t> airMask(const Patient& patient, int threads) {
    Volume<std::uint8_t> air(patient.grid());
    parallelVoxels(threads, air.grid, [&](const Index3& i) {
        const TissueSample s = patient.at(i, {});
        air[i] = s.tissue == Tissue::air && s.label == 0;
    });
    return air;
}

// Air connected to the sides of the image. Top and bottom do not count, because they cut through lungs and
// bowel.
Volume<std::uint8_t> outerAir(const Volume<std::uint8_t>& air) {
    Volume<std::uint8_t> outer(air.grid);
    const auto enter = [&](const Index3& i) {
        if (!air[i] || outer[i]) return false;
        outer[i] = 1;
        return true;
    };
    std::vector<Index3> seeds;
    forEachVoxel(air.grid, [&](const Index3& i) {
        if (air.grid.atSide(i) && enter(i)) seeds.push_back(i);
    });
    floodFaces(air.grid, std::move(seeds), enter);
    return outer;
}

// Signed distance to the border, which runs half a voxel from the centres on either side.
Volume<float> signedDistance(const Volume<std::uint8_t>& outer, int threads) {
    const Vec3 h = outer.grid.spacing_m;
    const float half = float(0.5 * std::min({h.x, h.y, h.z}));
    Volume<float> level = distanceTo(outer, Sites::all, threads);  // distance to outer air
    Volume<std::uint8_t> body = outer;
    for (std::uint8_t& b : body.voxels)
        b = b ? 0 : 1;
    const Volume<float> above = distanceTo(body, Sites::all, threads);
    // used if the image is all air or all body
    const float far = float(glm::length(h * Vec3(outer.grid.dims)));
    for (std::size_t i = 0; i < level.voxels.size(); ++i)
        level.voxels[i] =
            outer.voxels[i] ? std::min(above.voxels[i], far) - half : half - std::min(level.voxels[i], far);
    return level;
}

// Extrapolates the outermost nodes, which lie outside the image, linearly if there are enough nodes.
void extrapolateEnds(Volume<float>& v, int threads) {
    for (int axis = 0; axis < 3; ++axis)
        parallelLines(threads, v.grid.dims, axis, v.voxels.data(),
                      [](float* p, std::size_t stride, std::size_t count) {
                          if (count < 4) return;
                          p[0] = 2.0f * p[stride] - p[2 * stride];
                          p += (count - 1) * stride;
                          p[0] = 2.0f * *(p - stride) - *(p - 2 * stride);
                      });
}

// Averages blocks of voxels. Adds one node on every side, so that the spline covers the whole image.
Volume<float> averageToNodes(const Volume<float>& fine, int threads) {
    Index3 block, dims;
    for (int axis = 0; axis < 3; ++axis) {
        block[axis] = std::max(1, int(std::floor(kSkinNode_m / fine.grid.spacing_m[axis] + 0.5)));
        dims[axis] = 2 + (fine.grid.dims[axis] + block[axis] - 1) / block[axis];
    }
    const Vec3 pitch_m = fine.grid.spacing_m * Vec3(block);
    const Vec3 first = fine.grid.origin_m + 0.5 * fine.grid.spacing_m * Vec3(block - 1) - pitch_m;
    Volume<float> nodes(Grid{dims, pitch_m, first});
    const Index3 last = fine.grid.dims - 1;
    parallelVoxels(threads, nodes.grid, [&](const Index3& i) {
        const Index3 low = (i - 1) * block;
        double sum = 0.0;
        forEachVoxel(low, low + block - 1,
                     [&](const Index3& voxel) { sum += double(fine[glm::clamp(voxel, Index3(0), last)]); });
        nodes[i] = float(sum / double(block.x * block.y * block.z));
    });
    extrapolateEnds(nodes, threads);
    return nodes;
}

// Filter [1 2 1]/4 along one axis. The ends are unchanged, so linear functions are preserved.
void smoothAlong(Volume<float>& v, int axis, int threads) {
    parallelLines(threads, v.grid.dims, axis, v.voxels.data(),
                  [](float* p, std::size_t stride, std::size_t count) {
                      float before = p[0];
                      for (std::size_t i = 1; i + 1 < count; ++i) {
                          p += stride;
                          const float here = p[0];
                          p[0] = 0.25f * before + 0.5f * here + 0.25f * p[stride];
                          before = here;
                      }
                  });
}

Volume<float> smoothed(Volume<float> v, int threads) {
    for (int pass = 0; pass < kSmoothingPasses; ++pass)
        for (int axis = 0; axis < 3; ++axis)
            smoothAlong(v, axis, threads);
    return v;
}

}  // namespace

Skin makeSkin(const Patient& patient, int threads) {
    const Volume<float> rough =
        averageToNodes(signedDistance(outerAir(airMask(patient, threads)), threads), threads);
    // 2 G - G G: as smooth as G, but does not shift curved surfaces.
    Skin skin{smoothed(rough, threads)};
    const Volume<float> twice = smoothed(skin.level_m, threads);
    for (std::size_t i = 0; i < twice.voxels.size(); ++i)
        skin.level_m.voxels[i] = 2.0f * skin.level_m.voxels[i] - twice.voxels[i];
    return skin;
}

SkinPoint skinAt(const Skin& skin, const Vec3& reference_m) noexcept {
    const SplineSample<1> s = sampleSpline<1>(skin.level_m.grid, skin.level_m.voxels.data(), reference_m);
    return {s.value[0] + s.beyond_m, s.slope[0]};
}

Vec3 nearestSkinPoint(const Skin& skin, const Vec3& reference_m) noexcept {
    Vec3 p = reference_m;
    for (int i = 0; i < kNewtonSteps; ++i) {
        const SkinPoint s = skinAt(skin, p);
        p -= s.normal * (s.level_m / std::max(glm::dot(s.normal, s.normal), 0.25));
    }
    return p;
}

}  // namespace stylet::patient
