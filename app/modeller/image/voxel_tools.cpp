#include "app/modeller/image/voxel_tools.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <vector>

#include "app/modeller/image/mask_runs.h"
#include "base/parallel.h"

namespace stylet::modeller {

namespace {

constexpr float kFar = 1e6f;  // squared metres; means "no voxel of the mask"

// One pass of the Euclidean distance transform, along one line of voxels. For each voxel p of the line it
// computes the squared distance g(p) = min over q of f(q) + (spacing (p - q))^2. Here f(q) is the squared
// distance found along the other axes. The minimum over all voxels q is the lower envelope of
// parabolas with apex q.
struct Envelope {
    std::vector<float> f, begin;
    std::vector<int> apex;

    explicit Envelope(int n) : f(std::size_t(n)), begin(std::size_t(n) + 1), apex(std::size_t(n)) {}

    void transform(float* line, std::ptrdiff_t stride, int n, float spacing) {
        for (int i = 0; i < n; ++i)
            f[std::size_t(i)] = line[i * stride];
        const auto isZero = [&](int i) { return i >= 0 && i < n && f[std::size_t(i)] == 0.0f; };
        const float w = spacing * spacing;
        int k = -1;
        for (int q = 0; q < n; ++q) {
            const float fq = f[std::size_t(q)];
            // A voxel of the mask between two others is nearest only to itself.
            if (fq >= kFar || (isZero(q) && isZero(q - 1) && isZero(q + 1))) continue;
            float from = -1e9f;
            while (k >= 0) {
                const int p = apex[std::size_t(k)];
                from = ((fq - f[std::size_t(p)]) / w + float(q * q - p * p)) / float(2 * (q - p));
                if (from > begin[std::size_t(k)]) break;
                --k;
            }
            if (k < 0) from = -1e9f;
            apex[std::size_t(++k)] = q;
            begin[std::size_t(k)] = from;
        }
        if (k < 0) return;
        for (int p = 0, j = 0; p < n; ++p) {
            if (isZero(p)) continue;
            while (j < k && begin[std::size_t(j + 1)] <= float(p))
                ++j;
            const int q = apex[std::size_t(j)];
            line[p * stride] = w * float((p - q) * (p - q)) + f[std::size_t(q)];
        }
    }
};

// The component with the most voxels, or 0 if there is none.
std::size_t largestOf(const std::vector<std::size_t>& counts) {
    return std::size_t(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

}  // namespace

bool stepsAlongRow(const std::uint8_t* mask, int n, float* steps) {
    bool any = false;
    int count = n;  // from the last voxel of the mask
    for (int x = 0; x < n; ++x) {
        count = mask[x] ? 0 : count + 1;
        any = any || count == 0;
        steps[x] = float(count);
    }
    if (!any) return false;
    count = n;
    for (int x = n; x-- > 0;) {
        count = mask[x] ? 0 : count + 1;
        steps[x] = std::min(steps[x], float(count));
    }
    return true;
}

FloatVolume distanceTo(const Mask& mask) {
    const Grid& g = mask.grid;
    FloatVolume d(g);
    const std::ptrdiff_t row = g.dims.x, slice = std::ptrdiff_t(g.dims.x) * g.dims.y;
    parallelFor(processorCount(), g.dims.z, [&](int z) {
        float* base = d.voxels.data() + z * slice;
        Envelope along_y(g.dims.y);
        const float w = float(g.spacing_m.x) * float(g.spacing_m.x);
        for (int y = 0; y < g.dims.y; ++y) {
            float *const line = base + y * row, *const end = line + row;
            if (stepsAlongRow(&mask[{0, y, z}], g.dims.x, line))
                std::transform(line, end, line, [w](float steps) { return w * (steps * steps); });
            else
                std::fill(line, end, kFar);
        }
        for (int x = 0; x < g.dims.x; ++x)
            along_y.transform(base + x, row, g.dims.y, float(g.spacing_m.y));
    });
    parallelFor(processorCount(), g.dims.y, [&](int y) {
        Envelope along_z(g.dims.z);
        float* base = d.voxels.data() + y * row;
        for (int x = 0; x < g.dims.x; ++x)
            along_z.transform(base + x, slice, g.dims.z, float(g.spacing_m.z));
        for (int z = 0; z < g.dims.z; ++z)
            std::transform(base + z * slice, base + z * slice + row, base + z * slice,
                           [](float squared) { return std::sqrt(squared); });
    });
    return d;
}

Mask floodFill(const Mask& seeds, const Mask& passable) {
    const MaskRuns pieces(passable, Connectivity::faces);
    std::vector<std::uint8_t> reached(pieces.voxelCounts().size(), 0);
    for (const Run& run : pieces.runs()) {
        const std::uint8_t* const begin = seeds.voxels.data() + run.begin;
        const std::uint8_t* const end = seeds.voxels.data() + run.end;
        if (!reached[run.component] && nextSet(begin, end) != end) reached[run.component] = 1;
    }
    return pieces.where([&](std::size_t n) { return reached[n]; });
}

const std::uint8_t* nextSet(const std::uint8_t* at, const std::uint8_t* end) {
    std::uint64_t eight = 0;
    while (end - at >= std::ptrdiff_t(sizeof eight)) {
        std::memcpy(&eight, at, sizeof eight);
        if (eight != 0) break;
        at += sizeof eight;
    }
    return std::find_if(at, end, [](std::uint8_t v) { return v != 0; });
}

VoxelBox boundingBox(const Mask& m) {
    const Grid& g = m.grid;
    VoxelBox b{g.dims, Index3(-1)};
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y) {
            const std::uint8_t* row = m.voxels.data() + g.offset({0, y, z});
            const std::uint8_t* end = row + g.dims.x;
            const std::uint8_t* first = nextSet(row, end);
            if (first == end) continue;
            int last = g.dims.x - 1;
            while (!row[last])
                --last;
            b.low = glm::min(b.low, Index3(int(first - row), y, z));
            b.high = glm::max(b.high, Index3(last, y, z));
        }
    if (b.high.x < 0) return {Index3(0), Index3(-1)};
    return b;
}

VoxelBox boxAround(const Mask& mask, int margin) {
    const VoxelBox box = boundingBox(mask);
    if (box.empty()) return box;
    return {glm::max(box.low - margin, Index3(0)), glm::min(box.high + margin, mask.grid.dims - 1)};
}

void paste(const Mask& part, const Index3& low, Mask& into) {
    for (int z = 0; z < part.grid.dims.z; ++z)
        for (int y = 0; y < part.grid.dims.y; ++y)
            std::copy_n(&part[{0, y, z}], part.grid.dims.x, &into[low + Index3(0, y, z)]);
}

Mask withLabel(const LabelVolume& labels, std::uint8_t label) {
    return maskWhere(labels.grid, [&](std::size_t i) { return labels.voxels[i] == label; });
}

int Components::largest() const {
    return int(largestOf(size));
}

Components findComponents(const Mask& m, Connectivity touch) {
    const MaskRuns pieces(m, touch);
    Components p{Volume<std::int32_t>(m.grid), pieces.voxelCounts()};
    for (const Run& run : pieces.runs())
        std::fill(p.number.voxels.begin() + run.begin, p.number.voxels.begin() + run.end,
                  std::int32_t(run.component));
    return p;
}

std::size_t keepLargestComponent(Mask& mask) {
    const MaskRuns pieces(mask, Connectivity::faces);
    const std::vector<std::size_t>& count = pieces.voxelCounts();
    const std::size_t largest = largestOf(count);
    mask = pieces.where([&](std::size_t n) { return n == largest; });
    return std::accumulate(count.begin(), count.end(), std::size_t{0}) - count[largest];
}

Mask surroundedPieces(const Mask& pieces, const Mask& organ) {
    constexpr double kReach_m = 0.060, kInsideShare = 0.9;
    constexpr int kDirections = 4;
    const Grid& g = organ.grid;
    const auto isInside = [&](const Index3& from) {
        const auto leadsToOrgan = [&](const Index3& step) {
            const int steps = int(kReach_m / glm::length(Vec3(step) * g.spacing_m));
            for (int n = 1; n <= steps && g.contains(from + n * step); ++n)
                if (organ[from + n * step]) return true;
            return false;
        };
        return std::count_if(kFaceSteps.begin(), kFaceSteps.end(), leadsToOrgan) >= kDirections;
    };
    Mask is_inside(g);
    parallelVoxels(g, [&](const Index3& i) { is_inside[i] = pieces[i] && isInside(i); });
    const MaskRuns all(pieces, Connectivity::corners);
    std::vector<double> inside(all.voxelCounts().size(), 0.0);
    for (const Run& run : all.runs())
        inside[run.component] += double(std::count(is_inside.voxels.begin() + run.begin,
                                                   is_inside.voxels.begin() + run.end, std::uint8_t{1}));
    return all.where([&](std::size_t n) { return inside[n] >= kInsideShare * double(all.voxelCounts()[n]); });
}

void fillHolesPerSlice(Mask& mask) {
    const int nx = mask.grid.dims.x, ny = mask.grid.dims.y;
    parallelFor(processorCount(), mask.grid.dims.z, [&](int z) {
        std::uint8_t* slice = mask.voxels.data() + std::ptrdiff_t(z) * nx * ny;
        std::vector<std::uint8_t> outside(std::size_t(nx * ny), 0);
        std::vector<int> open;
        const auto visit = [&](int x, int y) {
            const int o = y * nx + x;
            if (x < 0 || y < 0 || x >= nx || y >= ny || slice[o] || outside[std::size_t(o)]) return;
            outside[std::size_t(o)] = 1;
            open.push_back(o);
        };
        for (int x = 0; x < nx; ++x)
            visit(x, 0), visit(x, ny - 1);
        for (int y = 0; y < ny; ++y)
            visit(0, y), visit(nx - 1, y);
        while (!open.empty()) {
            const int x = open.back() % nx, y = open.back() / nx;
            open.pop_back();
            visit(x + 1, y), visit(x - 1, y), visit(x, y + 1), visit(x, y - 1);
        }
        for (int o = 0; o < nx * ny; ++o)
            slice[o] = outside[std::size_t(o)] ? 0 : 1;
    });
}

FloatVolume boxMean(const FloatVolume& in, int reach) {
    FloatVolume out = in;
    const Index3 n = in.grid.dims;
    const std::size_t row = std::size_t(n.x), slice = row * std::size_t(n.y);
    // `width` values side by side in memory are averaged at once, along `length` places that are `stride`
    // apart.
    const auto average = [reach](float* first, int length, std::size_t stride, std::size_t width) {
        std::vector<double> sums((std::size_t(length) + 1) * width);
        const auto sum = [&](int i) { return sums.data() + std::size_t(i) * width; };
        for (int i = 0; i < length; ++i)
            for (std::size_t x = 0; x < width; ++x)
                sum(i + 1)[x] = sum(i)[x] + double(first[std::size_t(i) * stride + x]);
        for (int i = 0; i < length; ++i) {
            const int from = std::max(0, i - reach), to = std::min(length, i + reach + 1);
            const double *const low = sum(from), *const high = sum(to), count = double(to - from);
            float* const mean = first + std::size_t(i) * stride;
            for (std::size_t x = 0; x < width; ++x)
                mean[x] = float((high[x] - low[x]) / count);
        }
    };
    parallelFor(processorCount(), n.z, [&](int z) {
        float* const at = out.voxels.data() + std::size_t(z) * slice;
        for (int y = 0; y < n.y; ++y)
            average(at + std::size_t(y) * row, n.x, 1, 1);
        average(at, n.y, row, row);
    });
    parallelFor(processorCount(), n.y,
                [&](int y) { average(out.voxels.data() + std::size_t(y) * row, n.z, slice, row); });
    return out;
}

Mask inverted(Mask m) {
    for (std::uint8_t& v : m.voxels)
        v = v ? 0 : 1;
    return m;
}

}  // namespace stylet::modeller
