#include "app/modeller/image/voxel_tools.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "base/parallel.h"

namespace stylet::modeller {

namespace {

constexpr float kFar = 1e6f;  // squared metres; means "no voxel of the mask"

// One pass of the Euclidean distance transform, along one line of voxels. For each voxel p of the line it
// computes the squared distance g(p) = min over q of f(q) + (spacing (p - q))^2. Here f(q) is the squared
// distance found by the passes along the other axes. The minimum over all voxels q is the lower envelope of
// parabolas with apex q.
struct Envelope {
    std::vector<float> f, begin;
    std::vector<int> apex;

    explicit Envelope(int n) : f(std::size_t(n)), begin(std::size_t(n) + 1), apex(std::size_t(n)) {}

    void transform(float* line, std::ptrdiff_t stride, int n, float spacing) {
        for (int i = 0; i < n; ++i)
            f[std::size_t(i)] = line[i * stride];
        const float w = spacing * spacing;
        int k = -1;
        for (int q = 0; q < n; ++q) {
            const float fq = f[std::size_t(q)];
            if (fq >= kFar) continue;
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
            while (j < k && begin[std::size_t(j + 1)] <= float(p))
                ++j;
            const int q = apex[std::size_t(j)];
            line[p * stride] = w * float((p - q) * (p - q)) + f[std::size_t(q)];
        }
    }
};

}  // namespace

FloatVolume distanceTo(const Mask& mask) {
    const Grid& g = mask.grid;
    FloatVolume d(g);
    for (std::size_t i = 0; i < d.voxels.size(); ++i)
        d.voxels[i] = mask.voxels[i] ? 0.0f : kFar;
    const std::ptrdiff_t row = g.dims.x, slice = std::ptrdiff_t(g.dims.x) * g.dims.y;
    parallelFor(processorCount(), g.dims.z, [&](int z) {
        float* base = d.voxels.data() + z * slice;
        Envelope along_x(g.dims.x), along_y(g.dims.y);
        for (int y = 0; y < g.dims.y; ++y)
            along_x.transform(base + y * row, 1, g.dims.x, float(g.spacing_m.x));
        for (int x = 0; x < g.dims.x; ++x)
            along_y.transform(base + x, row, g.dims.y, float(g.spacing_m.y));
    });
    parallelFor(processorCount(), g.dims.y, [&](int y) {
        Envelope along_z(g.dims.z);
        for (int x = 0; x < g.dims.x; ++x)
            along_z.transform(d.voxels.data() + y * row + x, slice, g.dims.z, float(g.spacing_m.z));
    });
    for (float& v : d.voxels)
        v = std::sqrt(v);
    return d;
}

Mask floodFill(const Mask& seeds, const Mask& passable) {
    const Grid& g = passable.grid;
    Mask reached(g);
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < seeds.voxels.size(); ++i)
        if (seeds.voxels[i] && passable.voxels[i]) {
            reached.voxels[i] = 1;
            open.push_back(i);
        }
    while (!open.empty()) {
        const Index3 at = g.voxelAt(open.back());
        open.pop_back();
        forEachNeighbour(g, at, Connectivity::faces, [&](std::size_t to) {
            if (reached.voxels[to] || !passable.voxels[to]) return;
            reached.voxels[to] = 1;
            open.push_back(to);
        });
    }
    return reached;
}

VoxelBox boundingBox(const Mask& m) {
    const Grid& g = m.grid;
    VoxelBox b{g.dims, Index3(-1)};
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y) {
            const std::uint8_t* row = m.voxels.data() + g.offset({0, y, z});
            const std::uint8_t* end = row + g.dims.x;
            const std::uint8_t* first = std::find_if(row, end, [](std::uint8_t v) { return v != 0; });
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
    forEachVoxel(part.grid, [&](const Index3& i) { into[low + i] = part[i]; });
}

Mask withLabel(const LabelVolume& labels, std::uint8_t label) {
    return maskWhere(labels.grid, [&](std::size_t i) { return labels.voxels[i] == label; });
}

int Components::largest() const {
    if (size.size() < 2) return 0;
    return int(std::max_element(size.begin() + 1, size.end()) - size.begin());
}

Components findComponents(const Mask& m, Connectivity touch) {
    Components p{Volume<std::int32_t>(m.grid), {0}};
    std::vector<std::size_t> open;
    for (std::size_t seed = 0; seed < m.voxels.size(); ++seed) {
        if (!m.voxels[seed] || p.number.voxels[seed]) continue;
        const auto number = std::int32_t(p.size.size());
        p.size.push_back(0);
        p.number.voxels[seed] = number;
        open.assign(1, seed);
        while (!open.empty()) {
            const Index3 at = m.grid.voxelAt(open.back());
            open.pop_back();
            ++p.size.back();
            forEachNeighbour(m.grid, at, touch, [&](std::size_t to) {
                if (!m.voxels[to] || p.number.voxels[to]) return;
                p.number.voxels[to] = number;
                open.push_back(to);
            });
        }
    }
    return p;
}

std::size_t keepLargestComponent(Mask& mask) {
    const Components components = findComponents(mask);
    const auto largest = std::size_t(components.largest());
    mask = componentsWhere(components, [&](std::size_t n) { return n == largest; });
    return std::accumulate(components.size.begin(), components.size.end(), std::size_t{0}) -
           components.size[largest];
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
    const Components all = findComponents(pieces, Connectivity::corners);
    std::vector<double> inside(all.size.size(), 0.0);
    forEachVoxel(g, [&](const Index3& i) {
        if (pieces[i]) inside[std::size_t(all.number[i])] += isInside(i);
    });
    return componentsWhere(all,
                           [&](std::size_t n) { return inside[n] >= kInsideShare * double(all.size[n]); });
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
    const std::ptrdiff_t strides[3] = {1, n.x, std::ptrdiff_t(n.x) * n.y};
    for (int axis = 0; axis < 3; ++axis) {
        const int length = n[axis], outer = axis == 2 ? 1 : 2;
        const int count_a = n[outer == axis ? 0 : outer], count_b = n[axis == 0 ? 1 : 0];
        const std::ptrdiff_t stride_a = strides[outer == axis ? 0 : outer],
                             stride_b = strides[axis == 0 ? 1 : 0];
        parallelFor(processorCount(), count_a, [&](int a) {
            std::vector<double> sum(std::size_t(length) + 1);
            for (int b = 0; b < count_b; ++b) {
                float* line = out.voxels.data() + a * stride_a + b * stride_b;
                for (int i = 0; i < length; ++i)
                    sum[std::size_t(i) + 1] = sum[std::size_t(i)] + double(line[i * strides[axis]]);
                for (int i = 0; i < length; ++i) {
                    const int from = std::max(0, i - reach), to = std::min(length, i + reach + 1);
                    line[i * strides[axis]] =
                        float((sum[std::size_t(to)] - sum[std::size_t(from)]) / double(to - from));
                }
            }
        });
    }
    return out;
}

Mask inverted(Mask m) {
    for (std::uint8_t& v : m.voxels)
        v = v ? 0 : 1;
    return m;
}

}  // namespace stylet::modeller
