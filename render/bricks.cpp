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

constexpr double kRounding_m = 2e-5;  // of the tables' half floats

struct Box {
    patient::Vec3 low, high;
};

// Where the points of a box of the deformed patient come from, at most: linear interpolation stays within its
// nodes.
Box sourceOf(const DeformTables& tables, const Box& box) {
    const patient::Index3 last = tables.grid.dims - 1;
    const auto nodeAt = [&](const patient::Vec3& p, bool up) {
        const patient::Vec3 at = glm::clamp(tables.grid.toVoxels(p), patient::Vec3(0.0), patient::Vec3(last));
        return patient::Index3(up ? glm::ceil(at) : glm::floor(at));
    };
    const patient::Index3 first = nodeAt(box.low, false), end = nodeAt(box.high, true);
    glm::vec4 low_in(1e9f), high_in(-1e9f), low_out(1e9f), high_out(-1e9f);
    patient::Index3 i;
    for (i.z = first.z; i.z <= end.z; ++i.z)
        for (i.y = first.y; i.y <= end.y; ++i.y)
            for (i.x = first.x; i.x <= end.x; ++i.x) {
                const std::size_t at = tables.grid.offset(i);
                low_in = glm::min(low_in, tables.inside[at]), high_in = glm::max(high_in, tables.inside[at]);
                low_out = glm::min(low_out, tables.outside[at]);
                high_out = glm::max(high_out, tables.outside[at]);
            }
    glm::vec3 low(low_out), high(high_out);
    if (high_in.w < 0.0f) low = glm::vec3(low_in), high = glm::vec3(high_in);
    if (low_in.w < 0.0f) low = glm::min(low, glm::vec3(low_in)), high = glm::max(high, glm::vec3(high_in));
    return {box.low + patient::Vec3(low) - kRounding_m, box.high + patient::Vec3(high) + kRounding_m};
}

bool anyOccupied(const BrickGrid& grid, const patient::Index3& low, const patient::Index3& high) {
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x)
                if (grid.occupied[grid.offset(x, y, z)]) return true;
    return false;
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

BrickGrid deformOccupancy(const BrickGrid& reference, const patient::Grid& grid, const DeformTables& tables) {
    BrickGrid deformed = reference;
    const patient::Vec3 brick_m = grid.spacing_m * double(kBrickVoxels);
    const patient::Vec3 corner_m = grid.origin_m - 0.5 * grid.spacing_m;
    const patient::Vec3 last(reference.dims - 1);
    patient::Index3 i;
    for (i.z = 0; i.z < deformed.dims.z; ++i.z)
        for (i.y = 0; i.y < deformed.dims.y; ++i.y)
            for (i.x = 0; i.x < deformed.dims.x; ++i.x) {
                const patient::Vec3 low_m = corner_m + brick_m * patient::Vec3(i);
                const Box source = sourceOf(tables, {low_m, low_m + brick_m});
                const auto brickOf = [&](const patient::Vec3& p) {
                    const patient::Vec3 at = glm::floor((p - corner_m) / brick_m);
                    return patient::Index3(glm::clamp(at, patient::Vec3(0.0), last));
                };
                deformed.occupied[deformed.offset(i.x, i.y, i.z)] =
                    anyOccupied(reference, brickOf(source.low), brickOf(source.high));
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
