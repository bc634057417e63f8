// The volume being painted: a label and one byte of detail per voxel.
// Painters process slices on several threads. Each voxel depends only on earlier painters, so the thread
// count does not change the result.
#pragma once

#include <array>
#include <vector>

#include "base/parallel.h"
#include "base/volume.h"
#include "patient/synth/anatomy.h"
#include "patient/synth/labels.h"

namespace stylet::patient::synth {

// A voxel that a brush paints.
struct Voxel {
    std::uint8_t &label, &detail;
    void set(Id id, std::uint8_t new_detail = 0) const noexcept {
        label = std::uint8_t(id), detail = new_detail;
    }
};

struct Canvas {
    LabelVolume labels;
    std::vector<std::uint8_t> detail;
    Vec3 scale{1.0};
    int threads = 1;

    Canvas(const Grid& grid, const Vec3& scale_, int threads_)
        : labels(grid), detail(grid.voxelCount(), 0), scale(scale_), threads(threads_) {}

    const Grid& grid() const noexcept { return labels.grid; }
    // Centre of a voxel in anatomical millimetres.
    Vec3 at(const Index3& i) const noexcept { return grid().centre(i) * 1000.0 / scale; }
    double voxel_mm() const noexcept { return grid().spacing_m.x * 1000.0; }

    // The voxel range of a box, clipped to the grid.
    void range(const Box& box, Index3& first, Index3& last) const noexcept {
        for (int k = 0; k < 3; ++k) {
            const double s = scale[k] / 1000.0;
            const double low = (box.low[k] * s - grid().origin_m[k]) / grid().spacing_m[k];
            const double high = (box.high[k] * s - grid().origin_m[k]) / grid().spacing_m[k];
            first[k] = int(std::floor(std::clamp(low, 0.0, double(grid().dims[k] - 1))));
            last[k] = int(std::floor(std::clamp(high + 1.0, 0.0, double(grid().dims[k] - 1))));
        }
    }

    // Calls brush(p, voxel) for every voxel of the box whose label is in `onto`.
    template <class Brush>
    void paint(const Box& box, IdSet onto, const Brush& brush) {
        Index3 first, last;
        range(box, first, last);
        parallelFor(threads, last.z + 1 - first.z, [&](int slice) {
            const int z = first.z + slice;
            forEachVoxel({first.x, first.y, z}, {last.x, last.y, z}, [&](const Index3& i) {
                const std::size_t n = grid().offset(i);
                if (contains(onto, labels.voxels[n])) brush(at(i), Voxel{labels.voxels[n], detail[n]});
            });
        });
    }

    // Sets the label to `id` wherever distance(p) < 0.
    template <class Distance>
    void fill(const Box& box, IdSet onto, Id id, const Distance& distance) {
        paint(box, onto, [&](const Vec3& p, Voxel voxel) {
            if (distance(p) < 0.0) voxel.set(id);
        });
    }
};

// A thick polyline is a list of strokes, each a cone with round ends.
struct Stroke {
    Vec3 a, b;
    double ra, rb;
};

// Calls brush(p, hit, stroke, voxel) for every voxel inside a stroke whose label is in `onto`. A voxel in
// several strokes is painted in their order. The cost depends on the volume of the strokes, not of the grid.
template <class Brush>
void stamp(Canvas& canvas, const std::vector<Stroke>& strokes, IdSet onto, const Brush& brush) {
    const Grid& grid = canvas.grid();
    std::vector<std::array<Index3, 2>> ranges(strokes.size());
    std::vector<std::vector<std::size_t>> of_slice(std::size_t(grid.dims.z));
    for (std::size_t i = 0; i < strokes.size(); ++i) {
        const Stroke& s = strokes[i];
        canvas.range(boxAround(s.a, s.b, std::max(s.ra, s.rb)), ranges[i][0], ranges[i][1]);
        for (int z = ranges[i][0].z; z <= ranges[i][1].z; ++z)
            of_slice[std::size_t(z)].push_back(i);
    }
    parallelFor(canvas.threads, grid.dims.z, [&](int z) {
        for (const std::size_t i : of_slice[std::size_t(z)]) {
            const Stroke& s = strokes[i];
            const auto& [first, last] = ranges[i];
            forEachVoxel({first.x, first.y, z}, {last.x, last.y, z}, [&](const Index3& at) {
                const std::size_t n = grid.offset(at);
                if (!contains(onto, canvas.labels.voxels[n])) return;
                const Vec3 p = canvas.at(at);
                const ConeHit hit = roundCone(p, s.a, s.b, s.ra, s.rb);
                if (hit.distance < 0.0) brush(p, hit, s, Voxel{canvas.labels.voxels[n], canvas.detail[n]});
            });
        }
    });
}
// Sets the label and clears the detail.
void paintStrokes(Canvas&, const std::vector<Stroke>&, IdSet onto, Id);

inline std::uint8_t detailFrom(double share) noexcept {
    return std::uint8_t(clamp01(share) * 255.0 + 0.5);
}

// A smooth tube through control points (Catmull-Rom), divided into strokes of about `step_mm`. The radius
// varies by +-`bulge` (a share) with period `period_mm`, like haustra.
struct TubePoint {
    Vec3 p;
    double radius;
};
std::vector<Stroke> tube(const std::vector<TubePoint>&, double step_mm, double bulge = 0.0,
                         double period_mm = 1.0);

}  // namespace stylet::patient::synth
