#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "patient/package.h"
#include "render/mesh.h"

// A mesh whose indices name vertices and whose parts lie in its list, or a DataError.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::render;
    try {
        const Mesh mesh = parseMesh("fuzz.gltf", {data, size});
        for (const std::uint32_t index : mesh.indices)
            if (index >= mesh.vertices.size()) std::abort();
        for (const MeshPart& part : mesh.parts)
            if (part.first_index + part.index_count > mesh.indices.size()) std::abort();
    } catch (const stylet::patient::DataError&) {
    }
    return 0;
}
