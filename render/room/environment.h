// The room's light without the lamp, gathered at one point above the table: the map that polished surfaces
// mirror, and the irradiance from all directions. Computed at start from the room's dimensions.
//
// Based on Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps", 2001,
// Karis, "Real Shading in Unreal Engine 4", 2013 (prefiltering by roughness), and Engelhardt and
// Dachsbacher, "Octahedron Environment Maps", 2008.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "render/room/room_shared.h"

namespace stylet::render {

using gpu::kRoomHalf, gpu::kGatherPoint;

// Radiance that arrives at `from_m` (room frame) from a unit direction.
glm::vec3 roomRadiance(const glm::vec3& from_m, const glm::vec3& direction);

struct Environment {
    // The outermost texels lie on the octahedron's edge. Levels: roughness 0 to 1 in equal steps.
    static constexpr int kSize = gpu::kMapSize, kLevels = gpu::kMapLevels;
    static constexpr float kBrightest = gpu::kMapRange;
    std::array<glm::vec3, 9> irradiance{};  // divided by pi; multiplied by an albedo, it is radiance
    std::vector<glm::vec3> texels;          // level by level, row by row
};

// About 0.05 s on one thread.
Environment makeEnvironment();

// Maps a unit direction to coordinates in the map, -1 to 1, and back.
glm::vec2 octahedralFromDirection(const glm::vec3& direction);
glm::vec3 directionFromOctahedral(const glm::vec2& octahedral);

// Sum of the nine basis functions at a unit normal, as mesh.vert evaluates it.
glm::vec3 irradianceAt(const std::array<glm::vec3, 9>&, const glm::vec3& normal);

}  // namespace stylet::render
