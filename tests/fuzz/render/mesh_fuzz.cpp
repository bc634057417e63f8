#include <cmath>
#include <cstdint>

#include "render/room/mesh.h"
#include "tests/fuzz/parser_target.h"

// The result is a mesh or a DataError. Every index of an accepted mesh refers to a vertex, every part lies
// within the index list, and all numbers can be drawn.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet::render;
    const Mesh mesh = parseMesh("fuzz.gltf", fuzz::bytesOf(input));
    for (const std::uint32_t index : mesh.indices)
        if (index >= mesh.vertices.size()) std::abort();
    for (const MeshPart& part : mesh.parts) {
        if (part.first_index + part.index_count > mesh.indices.size()) std::abort();
        if (!(part.roughness >= 0.0f && part.roughness <= 1.0f)) std::abort();
    }
    for (const Vertex& v : mesh.vertices)
        if (!std::isfinite(v.uv.x) || !std::isfinite(v.uv.y) || !(v.open >= 0.0f && v.open <= 1.0f))
            std::abort();
}
