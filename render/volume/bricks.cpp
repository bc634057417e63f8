#include "render/volume/bricks.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "render/volume/lanes.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kFar = 255;

// Range of bricks whose interpolated samples read a voxel: its own brick, and the neighbouring one if the
// voxel lies at the edge.
struct Reach {
    int first, last;
};
Reach reach(int voxel, int bricks) {
    return {std::max(0, (voxel - 1) / kBrickVoxels), std::min(bricks - 1, (voxel + 1) / kBrickVoxels)};
}

constexpr double kRounding_m = 2e-5;  // rounding error of the tables' half floats

struct Box {
    Vec3 low, high;
};

constexpr Float4 kAbove{1e9f, 1e9f, 1e9f, 1e9f};
Float4 toLanes(const glm::vec4& v) {
    Float4 lanes;
    std::memcpy(&lanes, &v.x, sizeof lanes);
    return lanes;
}
glm::vec3 toVec3(Float4 v) {
    return {v[0], v[1], v[2]};
}

// Bounds of the reference points of a box of the deformed patient. Linear interpolation stays within the
// values of its nodes.
Box findSource(const DeformTables& tables, const Box& box) {
    const Index3 last = tables.grid.dims - 1;
    const auto nodeAt = [&](const Vec3& p, bool up) {
        const Vec3 at = glm::clamp(tables.grid.toVoxels(p), Vec3(0.0), Vec3(last));
        return Index3(up ? glm::ceil(at) : glm::floor(at));
    };
    const Index3 first = nodeAt(box.low, false), end = nodeAt(box.high, true);
    Float4 low_in = kAbove, high_in = -kAbove, low_out = kAbove, high_out = -kAbove;
    for (int z = first.z; z <= end.z; ++z)
        for (int y = first.y; y <= end.y; ++y) {
            const std::size_t row = tables.grid.offset({0, y, z});
            for (std::size_t at = row + std::size_t(first.x); at <= row + std::size_t(end.x); ++at) {
                const Float4 in = toLanes(tables.inside[at]), out = toLanes(tables.outside[at]);
                low_in = in < low_in ? in : low_in, high_in = in > high_in ? in : high_in;
                low_out = out < low_out ? out : low_out, high_out = out > high_out ? out : high_out;
            }
        }
    glm::vec3 low = toVec3(low_out), high = toVec3(high_out);
    if (high_in[3] < 0.0f) low = toVec3(low_in), high = toVec3(high_in);
    if (low_in[3] < 0.0f) low = glm::min(low, toVec3(low_in)), high = glm::max(high, toVec3(high_in));
    return {box.low + Vec3(low) - kRounding_m, box.high + Vec3(high) + kRounding_m};
}

bool anyOccupied(const BrickGrid& grid, const Index3& low, const Index3& high) {
    for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x)
                if (grid.occupied[grid.offset(x, y, z)]) return true;
    return false;
}

}  // namespace

BrickGrid::BrickGrid(const Index3& voxels)
    : dims((voxels + (kBrickVoxels - 1)) / kBrickVoxels),
      occupied(std::size_t(dims.x) * std::size_t(dims.y) * std::size_t(dims.z), 0) {}

void markOccupied(BrickGrid& grid, const Index3& voxels, int z0, int z1, const std::byte* rgba) {
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

namespace {

// The bricks of a patient's grid in metres.
struct BrickSpace {
    BrickSpace(const Grid& grid, const Index3& dims)
        : brick_m(grid.spacing_m * double(kBrickVoxels)),
          corner_m(grid.origin_m - 0.5 * grid.spacing_m),
          last(dims - 1) {}
    Index3 at(const Vec3& p) const {
        return Index3(glm::clamp(glm::floor((p - corner_m) / brick_m), Vec3(0.0), Vec3(last)));
    }
    Vec3 low_m(const Index3& brick) const { return corner_m + brick_m * Vec3(brick); }

    Vec3 brick_m, corner_m;
    Index3 last;
};

// True if any point of brick `i` of the deformed patient comes from an occupied brick.
bool seesOccupied(const BrickGrid& reference, const Grid& grid, const DeformTables& tables, const Index3& i) {
    const BrickSpace bricks(grid, reference.dims);
    const Vec3 low_m = bricks.low_m(i);
    const Box source = findSource(tables, {low_m, low_m + bricks.brick_m});
    return anyOccupied(reference, bricks.at(source.low), bricks.at(source.high));
}

}  // namespace

BreathingBricks::BreathingBricks(const BrickGrid& reference)
    : reference_(reference), occupancy_(reference), to_occupied_(leapDistances(reference)) {
    BrickGrid empty = reference;
    for (std::uint8_t& brick : empty.occupied)
        brick = !brick;
    to_empty_ = leapDistances(empty);
}

void BreathingBricks::update(const Grid& grid, const DeformTables& tables, double reach_m, Workers& workers) {
    const Vec3 brick_m = grid.spacing_m * double(kBrickVoxels);
    const double least_m = std::min({brick_m.x, brick_m.y, brick_m.z});
    const auto reach = std::uint32_t(std::ceil((reach_m + kRounding_m) / least_m));
    workers.run(std::size_t(occupancy_.dims.z), [&](std::size_t z, int) {
        Index3 i(0, 0, int(z));
        for (i.y = 0; i.y < occupancy_.dims.y; ++i.y)
            for (i.x = 0; i.x < occupancy_.dims.x; ++i.x) {
                const std::size_t at = occupancy_.offset(i.x, i.y, i.z);
                occupancy_.occupied[at] =
                    to_empty_[at] > reach ||
                    (to_occupied_[at] <= reach && seesOccupied(reference_, grid, tables, i));
            }
    });
}

void displaceOccupancy(const BrickGrid& breathed, const Grid& grid, const patient::DisplacementTable& tool,
                       BrickGrid& displaced) {
    displaced = breathed;
    const BrickSpace bricks(grid, breathed.dims);
    const Index3 last_node = tool.grid.dims - 1;
    const Index3 first = bricks.at(tool.grid.origin_m), end = bricks.at(tool.grid.centre(last_node));
    forEachVoxel({end - first + 1}, [&](const Index3& n) {
        const Index3 brick = first + n;
        const Vec3 low_m = bricks.low_m(brick), high_m = low_m + bricks.brick_m;
        const auto nodeAt = [&](const Vec3& at) {
            return Index3(glm::clamp(at, Vec3(0.0), Vec3(last_node)));
        };
        const Index3 from = nodeAt(glm::floor(tool.grid.toVoxels(low_m)));
        const Index3 to = nodeAt(glm::ceil(tool.grid.toVoxels(high_m)));
        glm::vec3 least(0.0f), most(0.0f);  // outside the table's box nothing moves
        forEachVoxel({to - from + 1}, [&](const Index3& i) {
            const glm::vec3 moved(tool.moved_m[tool.grid.offset(from + i)]);
            least = glm::min(least, moved), most = glm::max(most, moved);
        });
        displaced.occupied[displaced.offset(brick.x, brick.y, brick.z)] =
            anyOccupied(breathed, bricks.at(low_m - Vec3(most) - kRounding_m),
                        bricks.at(high_m - Vec3(least) + kRounding_m));
    });
}

// Chebyshev distance by two raster passes over the half-neighbourhoods (Rosenfeld and Pfaltz 1966). Exact
// for this metric.
std::vector<std::uint32_t> leapDistances(const BrickGrid& grid) {
    std::vector<std::uint32_t> distance;
    leapDistances(grid, distance);
    return distance;
}

void leapDistances(const BrickGrid& grid, std::vector<std::uint32_t>& distance) {
    distance.resize(grid.occupied.size());
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
}

}  // namespace stylet::render
