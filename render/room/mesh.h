// Meshes from glTF 2.0: positions, normals, texture coordinates, vertex colours as ambient occlusion and
// plain metallic-roughness materials, flattened to one list of triangles.
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
    float open = 1.0f;   // share of the light around that reaches it: COLOR_0's red
};

// One primitive. The parts of a node follow one another.
struct MeshPart {
    std::string name;  // of its material
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
// transforms are applied. Throws patient::DataError naming file, field and reason.
Mesh loadMesh(const std::filesystem::path&);
// The same from memory; `file` is named in what is thrown.
Mesh parseMesh(const std::filesystem::path& file, std::span<const unsigned char> bytes);

// A closed cylinder of radius 1 around z from 0 to 1, for lines drawn as tubes.
Mesh unitTube(int sides);

}  // namespace stylet::render
