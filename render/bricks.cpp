#include "render/bricks.h"

#include <algorithm>
#include <cmath>

namespace stylet::render {
namespace {

constexpr std::uint32_t kFar = 255;

// Bricks whose interpolated samples read voxel i: its own, and the neighbour's when it lies on the edge.
struct Reach {
    int first, last;
};
Reach reach(int voxel, int bricks) {
    return {std::max(0, (voxel - 1) / kBrickVoxels), std::min(bricks - 1, (voxel + 1) / kBrickVoxels)};
}

// Which slices of the reference a slice of the deformed patient may show, and how far sideways its points may
// move.
struct SliceSource {
    double z_low, z_high;
    double shift_x = 0.0, shift_y = 0.0;
};

// Centre and half-axes change piecewise linearly, so their extremes over a range lie at rows or at its ends.
void widen(SliceSource& source, const glm::vec4& here, const glm::vec4& there, double fade_rho) {
    const auto shift = [&](int axis) {
        const double radius_change = std::fabs(double(there[axis + 2]) - double(here[axis + 2]));
        return std::fabs(double(there[axis]) - double(here[axis])) + fade_rho * radius_change;
    };
    source.shift_x = std::max(source.shift_x, shift(0));
    source.shift_y = std::max(source.shift_y, shift(1));
}

SliceSource sliceSource(const BreathRows& breath, double z_low, double z_high) {
    SliceSource source{z_low, z_high};
    const int rows = int(breath.rows.size());
    const auto row = [&](double z) { return (z - breath.z_begin_m) / breath.dz_m; };
    const int first = std::clamp(int(std::floor(row(z_low))) - 1, 0, rows - 1);
    const int last = std::clamp(int(std::ceil(row(z_high))) + 1, 0, rows - 1);
    if (row(z_high) < 0.0 || row(z_low) > rows - 1) return source;
    for (int i = first; i <= last; ++i) {
        const gpu::BreathRow& r = breath.rows[std::size_t(i)];
        source.z_low = std::min({source.z_low, double(r.z.x), double(r.z.y)});
        source.z_high = std::max({source.z_high, double(r.z.x), double(r.z.y)});
    }
    const int from = std::clamp(int(std::floor(row(source.z_low))) - 1, 0, rows - 1);
    const int to = std::clamp(int(std::ceil(row(source.z_high))) + 1, 0, rows - 1);
    for (int i = first; i <= last; ++i)
        for (int k = from; k <= to; ++k)
            widen(source, breath.rows[std::size_t(i)].ellipse, breath.rows[std::size_t(k)].ellipse,
                  breath.fade_rho);
    return source;
}

// out(x, y) = any of `in` within +-rx, +-ry bricks; separable.
void dilate(std::vector<std::uint8_t>& mask, int width, int height, int rx, int ry) {
    std::vector<std::uint8_t> wide(mask.size(), 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (mask[std::size_t(y * width + x)])
                for (int k = std::max(0, x - rx); k <= std::min(width - 1, x + rx); ++k)
                    wide[std::size_t(y * width + k)] = 1;
    std::fill(mask.begin(), mask.end(), std::uint8_t(0));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (wide[std::size_t(y * width + x)])
                for (int k = std::max(0, y - ry); k <= std::min(height - 1, y + ry); ++k)
                    mask[std::size_t(k * width + x)] = 1;
}

}  // namespace

BrickGrid::BrickGrid(const patient::Index3& voxels)
    : dims((voxels + (kBrickVoxels - 1)) / kBrickVoxels),
      occupied(std::size_t(dims.x) * std::size_t(dims.y) * std::size_t(dims.z), 0) {}

void markOccupied(BrickGrid& grid, const patient::Index3& voxels, int z0, int z1, const std::byte* rgba) {
    std::vector<std::uint8_t> row(std::size_t(grid.dims.x));
    for (int z = z0; z < z1; ++z) {
        for (int y = 0; y < voxels.y; ++y) {
            std::fill(row.begin(), row.end(), std::uint8_t(0));
            const std::byte* texel = rgba + (std::size_t(z - z0) * std::size_t(voxels.y) + std::size_t(y)) *
                                                std::size_t(voxels.x) * 4;
            for (int x = 0; x < voxels.x; ++x) {
                if (texel[std::size_t(x) * 4 + 3] == std::byte{0}) continue;
                const Reach along = reach(x, grid.dims.x);
                row[std::size_t(along.first)] = row[std::size_t(along.last)] = 1;
            }
            const Reach in_y = reach(y, grid.dims.y), in_z = reach(z, grid.dims.z);
            for (const int bz : {in_z.first, in_z.last})
                for (const int by : {in_y.first, in_y.last})
                    for (int bx = 0; bx < grid.dims.x; ++bx)
                        grid.occupied[grid.offset(bx, by, bz)] |= row[std::size_t(bx)];
        }
    }
}

BrickGrid deformOccupancy(const BrickGrid& reference, const patient::Grid& grid, const BreathRows& breath) {
    BrickGrid deformed = reference;
    const std::size_t slice = std::size_t(reference.dims.x) * std::size_t(reference.dims.y);
    const patient::Vec3 brick_m = grid.spacing_m * double(kBrickVoxels);
    const double bottom = grid.origin_m.z - 0.5 * grid.spacing_m.z;
    std::vector<std::uint8_t> mask(slice);
    for (int z = 0; z < deformed.dims.z; ++z) {
        const SliceSource source = sliceSource(breath, bottom + z * brick_m.z, bottom + (z + 1) * brick_m.z);
        const int low =
            std::clamp(int(std::floor((source.z_low - bottom) / brick_m.z)), 0, deformed.dims.z - 1);
        const int high =
            std::clamp(int(std::floor((source.z_high - bottom) / brick_m.z)), 0, deformed.dims.z - 1);
        std::fill(mask.begin(), mask.end(), std::uint8_t(0));
        for (int k = low; k <= high; ++k)
            for (std::size_t i = 0; i < slice; ++i)
                mask[i] |= reference.occupied[std::size_t(k) * slice + i];
        dilate(mask, deformed.dims.x, deformed.dims.y, int(std::ceil(source.shift_x / brick_m.x)),
               int(std::ceil(source.shift_y / brick_m.y)));
        std::copy(mask.begin(), mask.end(),
                  deformed.occupied.begin() + std::ptrdiff_t(std::size_t(z) * slice));
    }
    return deformed;
}

// The chessboard distance by two raster passes over the half-neighbourhoods (Rosenfeld and Pfaltz 1966);
// exact for this metric.
std::vector<std::uint32_t> leapDistances(const BrickGrid& grid) {
    std::vector<std::uint32_t> distance(grid.occupied.size());
    for (std::size_t i = 0; i < distance.size(); ++i)
        distance[i] = grid.occupied[i] ? 0 : kFar;
    const auto relax = [&](int x, int y, int z, int direction) {
        std::uint32_t best = distance[grid.offset(x, y, z)];
        for (int n = 0; n < 13; ++n) {  // the 13 neighbours that a raster scan in this direction has passed
            const int dx = (n % 3) - 1, dy = (n / 3 % 3) - 1, dz = (n / 9) - 1;
            const int nx = x + direction * dx, ny = y + direction * dy, nz = z + direction * dz;
            if (nx < 0 || ny < 0 || nz < 0 || nx >= grid.dims.x || ny >= grid.dims.y || nz >= grid.dims.z)
                continue;
            best = std::min(best, distance[grid.offset(nx, ny, nz)] + 1);
        }
        distance[grid.offset(x, y, z)] = best;
    };
    for (int z = 0; z < grid.dims.z; ++z)
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x)
                relax(x, y, z, 1);
    for (int z = grid.dims.z - 1; z >= 0; --z)
        for (int y = grid.dims.y - 1; y >= 0; --y)
            for (int x = grid.dims.x - 1; x >= 0; --x)
                relax(x, y, z, -1);
    return distance;
}

}  // namespace stylet::render
