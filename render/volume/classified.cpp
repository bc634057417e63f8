#include "render/volume/classified.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.h"

namespace stylet::render {
namespace {

// Rows are smoothed in pieces of this many voxels. A piece is skipped if it and its neighbours are fully
// transparent ("clear"). A piece must be at least as long as the filter's radius, so that only neighbours
// matter.
constexpr int kPiece = 16;

struct Plane {
    Plane(int width_in, int height_in)
        : width(width_in),
          height(height_in),
          pieces((width_in + kPiece - 1) / kPiece),
          texels(std::size_t(width_in) * std::size_t(height_in)),
          seen(std::size_t(pieces) * std::size_t(height_in)) {}

    glm::vec4* row(int y) { return texels.data() + std::ptrdiff_t(y) * width; }
    std::uint8_t* visitRow(int y) { return seen.data() + std::ptrdiff_t(y) * pieces; }
    int pieceEnd(int piece) const { return std::min(width, (piece + 1) * kPiece); }
    void clear(int y, int piece) {
        std::fill(row(y) + piece * kPiece, row(y) + pieceEnd(piece), glm::vec4(0.0f));
        visitRow(y)[piece] = 0;
    }

    int width, height, pieces;
    std::vector<glm::vec4> texels;
    std::vector<std::uint8_t> seen;  // 0: the piece is clear
};

bool onBorder(const LabelVolume& labels, const Palette& palette, const Index3& at, std::uint8_t id) {
    for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) {
            Index3 beside = at;
            beside[axis] += side;
            if (labels.grid.contains(beside) && palette.borders(id, labels[beside])) return true;
        }
    return false;
}

void classifyPlane(const patient::Package& package, const Palette& palette, int z, Plane& out) {
    for (int y = 0; y < out.height; ++y) {
        glm::vec4* row = out.row(y);
        const std::size_t first = package.ct.grid.offset({0, y, z});
        const std::uint8_t* ids = package.labels.voxels.data() + first;
        const std::int16_t* hu = package.ct.voxels.data() + first;
        std::fill(out.visitRow(y), out.visitRow(y) + out.pieces, std::uint8_t(0));
        for (int x = 0; x < out.width; ++x) {
            const std::uint8_t id = ids[x];
            const bool shell = palette.shell[id] && onBorder(package.labels, palette, {x, y, z}, id);
            row[x] = shell                    ? *palette.shell[id]
                     : palette.follows_hu[id] ? palette.at(hu[x], id)
                                              : palette.label[id];
            if (row[x].a > 0.0f) out.visitRow(y)[x / kPiece] = 1;
        }
    }
}

// Row 2r of Pascal's triangle divided by 4^r: the binomial filter of radius r.
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

// Smooths along x; edge values repeat.
void smoothRows(Plane& in, Plane& out, const std::vector<float>& weights) {
    const int radius = int(weights.size()) / 2;
    for (int y = 0; y < in.height; ++y)
        for (int piece = 0; piece < in.pieces; ++piece) {
            const std::uint8_t* seen = in.visitRow(y);
            if (!seen[piece] && !seen[std::max(piece - 1, 0)] && !seen[std::min(piece + 1, in.pieces - 1)]) {
                out.clear(y, piece);
                continue;
            }
            out.visitRow(y)[piece] = 1;
            for (int x = piece * kPiece; x < in.pieceEnd(piece); ++x) {
                glm::vec4 sum(0.0f);
                for (int k = -radius; k <= radius; ++k)
                    sum += weights[std::size_t(k + radius)] * in.row(y)[std::clamp(x + k, 0, in.width - 1)];
                out.row(y)[x] = sum;
            }
        }
}

// Sets row y of `out` to the weighted sum of several rows: row `rowOf(k)` of plane `planeOf(k)`, for each k
// from -radius to radius. A piece is clear if it is clear in all these rows.
template <typename PlaneOf, typename RowOf>
void sumPieces(Plane& out, int y, const std::vector<float>& weights, const PlaneOf& planeOf,
               const RowOf& rowOf) {
    const int radius = int(weights.size()) / 2;
    for (int piece = 0; piece < out.pieces; ++piece) {
        out.clear(y, piece);
        for (int k = -radius; k <= radius; ++k) {
            Plane& in = planeOf(k);
            const int from = rowOf(k);
            if (!in.visitRow(from)[piece]) continue;
            const float weight = weights[std::size_t(k + radius)];
            for (int x = piece * kPiece; x < out.pieceEnd(piece); ++x)
                out.row(y)[x] += weight * in.row(from)[x];
            out.visitRow(y)[piece] = 1;
        }
    }
}

void smoothPlane(Plane& plane, Plane& scratch, const std::vector<float>& weights) {
    smoothRows(plane, scratch, weights);
    for (int y = 0; y < plane.height; ++y)
        sumPieces(
            plane, y, weights, [&](int) -> Plane& { return scratch; },
            [&](int k) { return std::clamp(y + k, 0, plane.height - 1); });
}

void storePlane(Plane& plane, const Palette& palette, std::byte* rgba) {
    const float low = palette.edge_low, stretch = 1.0f / (palette.edge_high - palette.edge_low);
    for (int y = 0; y < plane.height; ++y)
        for (int x = 0; x < plane.width; ++x, rgba += 4) {
            const glm::vec4 smooth = plane.row(y)[x];
            if (!plane.visitRow(y)[x / kPiece]) {
                std::fill_n(rgba, 4, std::byte{0});
                continue;
            }
            const float opacity = std::clamp((smooth.a - low) * stretch, 0.0f, 1.0f);
            const float weight = smooth.a > 0.0f ? opacity / smooth.a : 0.0f;
            const glm::vec4 texel = 255.0f * weight * smooth + 0.5f;
            const bool clear = texel.a < 2.0f;
            for (int c = 0; c < 4; ++c)
                rgba[c] = clear ? std::byte{0} : std::byte(std::uint8_t(std::min(texel[c], 255.0f)));
        }
}

void classifyRange(const patient::Patient& patient, const Palette& palette, int z0, int z1, std::byte* rgba) {
    const Index3 dims = patient.grid().dims;
    const std::size_t texels = std::size_t(dims.x) * std::size_t(dims.y);
    const std::vector<float> weights = binomial(palette.smoothing_voxels);
    const int radius = palette.smoothing_voxels, span = 2 * radius + 1;
    std::vector<Plane> ring{std::size_t(span), Plane(dims.x, dims.y)};  // plane z at (z + radius) % span
    Plane scratch(dims.x, dims.y), sum(dims.x, dims.y);
    const auto slot = [&](int z) -> Plane& { return ring[std::size_t((z + radius) % span)]; };
    const auto load = [&](int z) {
        classifyPlane(patient.package(), palette, std::clamp(z, 0, dims.z - 1), slot(z));
        smoothPlane(slot(z), scratch, weights);
    };
    for (int z = z0 - radius; z < z0 + radius; ++z)
        load(z);
    for (int z = z0; z < z1; ++z) {
        load(z + radius);
        for (int y = 0; y < dims.y; ++y)
            sumPieces(sum, y, weights, [&](int k) -> Plane& { return slot(z + k); }, [&](int) { return y; });
        storePlane(sum, palette, rgba + std::size_t(z - z0) * texels * 4);
    }
}

}  // namespace

void classifyPlanes(const patient::Patient& patient, const Palette& palette, int z0, int z1, std::byte* rgba,
                    int threads) {
    const Index3 dims = patient.grid().dims;
    const std::size_t plane_bytes = std::size_t(dims.x) * std::size_t(dims.y) * 4;
    parallelFor(threads, threads, [&](int i) {
        const int from = z0 + (z1 - z0) * i / threads, to = z0 + (z1 - z0) * (i + 1) / threads;
        if (from < to) classifyRange(patient, palette, from, to, rgba + std::size_t(from - z0) * plane_bytes);
    });
}

}  // namespace stylet::render
