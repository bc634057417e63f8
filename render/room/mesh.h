// Meshes from glTF 2.0, flattened to one list of triangles. Reads positions, normals, texture coordinates,
// ambient occlusion (vertex colours) and plain metallic-roughness materials.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace stylet::render {

struct Vertex {
    glm::vec3 position_m{0.0f};
    glm::vec3 normal{0.0f};
    glm::vec2 uv{0.0f};  // v points down
    float open = 1.0f;   // share of the ambient light that reaches it: red of COLOR_0
};

// One primitive. The parts of a node are contiguous.
struct MeshPart {
    std::string name;  // name of its material
    std::string node;
    std::uint32_t first_index = 0, index_count = 0;
    glm::vec3 colour_linear{0.8f}, emission_linear{0.0f};
    float metallic = 0.0f, roughness = 0.8f;  // 0 to 1
};

struct Mesh {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;  // triangles
    std::vector<MeshPart> parts;
};

// Reads .glb or .gltf whose buffers are embedded; every offset, stride, count and index is checked here. Node
// transforms are applied. Throws DataError naming file, field and reason.
Mesh loadMesh(const std::filesystem::path&);
// The same from memory; errors name `file`.
Mesh parseMesh(const std::filesystem::path& file, std::span<const unsigned char> bytes);

// A closed cylinder of radius 1 around z from 0 to 1, for lines drawn as tubes.
Mesh unitTube(int sides);
// A closed cone: a base of radius 1 at z = 0, its apex at z = 1.
Mesh unitCone(int sides);
// A torus around z with major radius 1 and minor radius `tube_radius`.
Mesh unitRing(int sides, int tube_sides, float tube_radius);

}  // namespace stylet::render
