#include "render/room/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include <tiny_gltf.h>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>

#include "base/whole_file.h"
#include "patient/package/package.h"

namespace stylet::render {
namespace {

using std::filesystem::path;

constexpr std::size_t kMaxFileBytes = 64u << 20;
constexpr std::size_t kMaxVertices = 4u << 20;
constexpr std::size_t kMaxIndices = 6 * kMaxVertices;
constexpr double kFarthest_m = 1e4;
constexpr int kMaxDepth = 32;  // depth of the node tree

using Bytes = std::span<const unsigned char>;

std::uint32_t word(Bytes bytes, std::size_t at) {
    return std::uint32_t(bytes[at]) | std::uint32_t(bytes[at + 1]) << 8 | std::uint32_t(bytes[at + 2]) << 16 |
           std::uint32_t(bytes[at + 3]) << 24;
}

// Checks the chunk lengths of a GLB before tinygltf does: version 2.7 accepts a binary chunk that ends
// eight bytes past the file.
void checkChunks(const path& file, Bytes bytes) {
    if (bytes.size() < 20) throw DataError(file, "header", "shorter than 20 bytes");
    if (word(bytes, 4) != 2) throw DataError(file, "version", std::to_string(word(bytes, 4)) + " is not 2");
    if (word(bytes, 8) != bytes.size())
        throw DataError(file, "length", std::to_string(word(bytes, 8)) + " is not the file's size");
    std::size_t at = 12;
    while (at < bytes.size()) {
        if (bytes.size() - at < 8) throw DataError(file, "chunk", "its header is cut");
        const std::size_t length = word(bytes, at);
        if (length > bytes.size() - at - 8) throw DataError(file, "chunk", "reaches past the file's end");
        at += 8 + length;
    }
}

tinygltf::Model parse(const path& file, Bytes bytes) {
    tinygltf::TinyGLTF loader;
    // Everything must be embedded: no file outside can be read.
    loader.SetFsCallbacks(
        {[](const std::string&, void*) { return false; }, [](const std::string& name, void*) { return name; },
         [](std::vector<unsigned char>*, std::string* error, const std::string& name, void*) {
             *error = "'" + name + "' lies outside the file";
             return false;
         },
         nullptr, nullptr});
    loader.SetImageLoader([](tinygltf::Image*, const int, std::string*, std::string*, int, int,
                             const unsigned char*, int, void*) { return true; },
                          nullptr);
    tinygltf::Model model;
    std::string error, warning;
    bool ok = false;
    const bool binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
    if (binary) checkChunks(file, bytes);
    try {
        const auto size = static_cast<unsigned>(bytes.size());
        ok = binary ? loader.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(), size)
                    : loader.LoadASCIIFromString(&model, &error, &warning,
                                                 reinterpret_cast<const char*>(bytes.data()), size, "");
    } catch (const std::exception& e) {
        error = e.what();
    }
    if (!ok) throw DataError(file, "glTF", error.empty() ? "could not be parsed" : error);
    return model;
}

// Elements of one to four components, in the layout of an accessor. All of their bytes have been checked to
// lie in the buffer.
struct Elements {
    const unsigned char* data = nullptr;
    std::size_t count = 0, stride = 0;
    int component = 0;
};

// A parsed glTF file. `file` names it in errors.
struct GltfFile {
    const path& file;
    const tinygltf::Model& model;

    [[noreturn]] void refuse(const std::string& field, const std::string& reason) const {
        throw DataError(file, field, reason);
    }
    // Returns the element at an index that was read from the file. Throws DataError if there is none.
    template <typename Element>
    const Element& at(const std::vector<Element>& list, int index, const std::string& field,
                      const char* what) const {
        if (index < 0 || std::size_t(index) >= list.size()) refuse(field, std::string("no such ") + what);
        return list[std::size_t(index)];
    }
};

Elements findElements(const GltfFile& gltf, int index, int type, const std::string& field) {
    const auto refuse = [&](const std::string& reason) { gltf.refuse(field, reason); };
    const tinygltf::Accessor& accessor = gltf.at(gltf.model.accessors, index, field, "accessor");
    if (accessor.sparse.isSparse) refuse("sparse accessors are not read");
    if (accessor.type != type) refuse("of the wrong type");
    const auto& view = gltf.at(gltf.model.bufferViews, accessor.bufferView, field, "buffer view");
    const auto& bytes = gltf.at(gltf.model.buffers, view.buffer, field, "buffer").data;
    const int component_bytes = tinygltf::GetComponentSizeInBytes(std::uint32_t(accessor.componentType));
    if (component_bytes <= 0) refuse("of an unknown component type");
    const std::size_t element =
        std::size_t(component_bytes * tinygltf::GetNumComponentsInType(std::uint32_t(type)));
    const std::size_t stride = view.byteStride != 0 ? view.byteStride : element;
    if (stride < element || stride > 252) refuse("a stride of " + std::to_string(stride) + " bytes");
    if (accessor.count == 0 || accessor.count > kMaxVertices)
        refuse("a count of " + std::to_string(accessor.count));
    if (view.byteOffset > bytes.size() || view.byteLength > bytes.size() - view.byteOffset)
        refuse("its view reaches past the buffer");
    const std::size_t last = (accessor.count - 1) * stride + element;
    if (accessor.byteOffset > view.byteLength || last > view.byteLength - accessor.byteOffset)
        refuse("reaches past its view");
    return {bytes.data() + view.byteOffset + accessor.byteOffset, accessor.count, stride,
            accessor.componentType};
}

// Reads an attribute as floats. Empty if there is none of that name.
template <int kWidth>
std::vector<glm::vec<kWidth, float>> readFloats(const GltfFile& gltf, const tinygltf::Primitive& primitive,
                                                const char* name, const std::string& where) {
    using Row = glm::vec<kWidth, float>;
    const std::string field = where + "." + name;
    const auto found = primitive.attributes.find(name);
    if (found == primitive.attributes.end()) return {};
    const int type = kWidth == 2 ? TINYGLTF_TYPE_VEC2 : TINYGLTF_TYPE_VEC3;
    const Elements list = findElements(gltf, found->second, type, field);
    if (list.component != TINYGLTF_COMPONENT_TYPE_FLOAT) gltf.refuse(field, "not of floats");
    std::vector<Row> rows(list.count);
    for (std::size_t i = 0; i < list.count; ++i) {
        std::memcpy(&rows[i], list.data + i * list.stride, sizeof(Row));
        for (int c = 0; c < kWidth; ++c)
            if (!std::isfinite(rows[i][c]))
                gltf.refuse(field, "entry " + std::to_string(i) + " is not finite");
    }
    return rows;
}

std::vector<glm::vec3> readVectors(const GltfFile& gltf, const tinygltf::Primitive& primitive,
                                   const char* name, const std::string& where) {
    auto vectors = readFloats<3>(gltf, primitive, name, where);
    if (vectors.empty()) gltf.refuse(where + "." + name, "missing");
    return vectors;
}

// Reads the ambient occlusion, which our scripts bake into grey vertex colours of four normalised bytes.
std::vector<float> readOpenness(const GltfFile& gltf, const tinygltf::Primitive& primitive,
                                const std::string& where) {
    const std::string field = where + ".COLOR_0";
    const auto found = primitive.attributes.find("COLOR_0");
    if (found == primitive.attributes.end()) return {};
    const Elements list = findElements(gltf, found->second, TINYGLTF_TYPE_VEC4, field);
    if (list.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) gltf.refuse(field, "not of bytes");
    std::vector<float> open(list.count);
    for (std::size_t i = 0; i < list.count; ++i)
        open[i] = float(list.data[i * list.stride]) / 255.0f;
    return open;
}

std::vector<std::uint32_t> readIndices(const GltfFile& gltf, const tinygltf::Primitive& primitive,
                                       std::size_t vertices, const std::string& where) {
    const std::string field = where + ".indices";
    const Elements list = findElements(gltf, primitive.indices, TINYGLTF_TYPE_SCALAR, field);
    const bool is_short = list.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    if (!is_short && list.component != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        gltf.refuse(field, "neither 16 nor 32 bits wide");
    if (list.count % 3 != 0) gltf.refuse(field, "not a whole number of triangles");
    std::vector<std::uint32_t> indices(list.count);
    for (std::size_t i = 0; i < list.count; ++i) {
        std::uint16_t narrow = 0;
        if (is_short) {
            std::memcpy(&narrow, list.data + i * list.stride, sizeof narrow);
            indices[i] = narrow;
        } else {
            std::memcpy(&indices[i], list.data + i * list.stride, sizeof indices[i]);
        }
        if (indices[i] >= vertices)
            gltf.refuse(field, "entry " + std::to_string(i) + " names vertex " + std::to_string(indices[i]) +
                                   " of " + std::to_string(vertices));
    }
    return indices;
}

// Checks that a factor of a material lies in 0 to 1.
float factor(const path& file, double value, const std::string& field) {
    if (!(value >= 0.0 && value <= 1.0))
        throw DataError(file, field, std::to_string(value) + " lies outside 0 to 1");
    return float(value);
}

glm::vec3 factors(const path& file, const std::vector<double>& values, const std::string& field) {
    if (values.size() < 3) throw DataError(file, field, "fewer than three numbers");
    return {factor(file, values[0], field), factor(file, values[1], field), factor(file, values[2], field)};
}

MeshPart readMaterial(const GltfFile& gltf, int index, const std::string& where) {
    MeshPart part;
    if (index < 0) return part;
    const auto& material = gltf.at(gltf.model.materials, index, where + ".material", "material");
    const auto& pbr = material.pbrMetallicRoughness;
    const std::string field = "materials[" + std::to_string(index) + "]";
    part.name = material.name;
    if (!pbr.baseColorFactor.empty())
        part.colour_linear = factors(gltf.file, pbr.baseColorFactor, field + ".baseColorFactor");
    part.metallic = factor(gltf.file, pbr.metallicFactor, field + ".metallicFactor");
    part.roughness = factor(gltf.file, pbr.roughnessFactor, field + ".roughnessFactor");
    if (!material.emissiveFactor.empty())
        part.emission_linear = factors(gltf.file, material.emissiveFactor, field + ".emissiveFactor");
    return part;
}

glm::dmat4 nodeTransform(const path& file, const tinygltf::Node& node, const std::string& where) {
    const auto wrong = [&](const std::vector<double>& v, std::size_t n) {
        return !v.empty() && v.size() != n;
    };
    if (wrong(node.matrix, 16) || wrong(node.rotation, 4) || wrong(node.scale, 3) ||
        wrong(node.translation, 3))
        throw DataError(file, where, "a transform of the wrong length");
    if (!node.matrix.empty()) return glm::make_mat4(node.matrix.data());
    glm::dmat4 m(1.0);
    if (!node.translation.empty())
        m[3] = {node.translation[0], node.translation[1], node.translation[2], 1.0};
    if (!node.rotation.empty())
        m *= glm::mat4_cast(
            glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]));
    if (!node.scale.empty())
        for (int axis = 0; axis < 3; ++axis)
            m[axis] *= node.scale[std::size_t(axis)];
    return m;
}

void appendPrimitive(const GltfFile& gltf, const tinygltf::Primitive& primitive, const std::string& node,
                     const glm::dmat4& root_from_node, const std::string& where, Mesh& mesh) {
    if (primitive.mode != TINYGLTF_MODE_TRIANGLES) gltf.refuse(where + ".mode", "only triangles are read");
    const auto positions = readVectors(gltf, primitive, "POSITION", where);
    const auto normals = readVectors(gltf, primitive, "NORMAL", where);
    const auto checkCount = [&](const auto& values, const char* name) {
        if (!values.empty() && values.size() != positions.size())
            gltf.refuse(where + name, "not one for each position");
    };
    checkCount(normals, ".NORMAL");
    const auto uvs = readFloats<2>(gltf, primitive, "TEXCOORD_0", where);
    checkCount(uvs, ".TEXCOORD_0");
    const auto open = readOpenness(gltf, primitive, where);
    checkCount(open, ".COLOR_0");
    if (mesh.vertices.size() + positions.size() > kMaxVertices) gltf.refuse(where, "too many vertices");
    const auto indices = readIndices(gltf, primitive, positions.size(), where);
    if (mesh.indices.size() + indices.size() > kMaxIndices) gltf.refuse(where, "too many triangles");
    MeshPart part = readMaterial(gltf, primitive.material, where);
    part.node = node;
    part.first_index = std::uint32_t(mesh.indices.size());
    part.index_count = std::uint32_t(indices.size());
    const auto base = std::uint32_t(mesh.vertices.size());
    const glm::dmat3 turn = glm::transpose(glm::inverse(glm::dmat3(root_from_node)));
    for (std::size_t i = 0; i < positions.size(); ++i) {
        const glm::dvec3 p(root_from_node * glm::dvec4(glm::dvec3(positions[i]), 1.0));
        // Where the faces of a fold cancel out there is no normal. Any direction is acceptable there.
        const glm::dvec3 across = turn * glm::dvec3(normals[i]);
        const double length = glm::length(across);
        const glm::dvec3 normal = length > 1e-9 && length < 1e9 ? across / length : glm::dvec3(0.0, 1.0, 0.0);
        if (!(glm::length(p) < kFarthest_m)) gltf.refuse(where + ".POSITION", "beyond all measure");
        mesh.vertices.push_back({glm::vec3(p), glm::vec3(normal), uvs.empty() ? glm::vec2(0.0f) : uvs[i],
                                 open.empty() ? 1.0f : open[i]});
    }
    for (const std::uint32_t index : indices)
        mesh.indices.push_back(base + index);
    mesh.parts.push_back(part);
}

void appendNode(const GltfFile& gltf, int index, const glm::dmat4& root_from_parent, int depth,
                std::vector<bool>& seen, Mesh& mesh) {
    const std::string where = "nodes[" + std::to_string(index) + "]";
    const tinygltf::Node& node = gltf.at(gltf.model.nodes, index, where, "node");
    if (seen[std::size_t(index)]) gltf.refuse(where, "reached twice: the nodes are not a tree");
    seen[std::size_t(index)] = true;
    if (depth > kMaxDepth) gltf.refuse(where, "nodes nested too deep");
    const glm::dmat4 root_from_node = root_from_parent * nodeTransform(gltf.file, node, where);
    if (node.mesh >= 0) {
        const auto& primitives = gltf.at(gltf.model.meshes, node.mesh, where + ".mesh", "mesh").primitives;
        for (std::size_t i = 0; i < primitives.size(); ++i)
            appendPrimitive(gltf, primitives[i], node.name, root_from_node,
                            "meshes[" + std::to_string(node.mesh) + "].primitives[" + std::to_string(i) + "]",
                            mesh);
    }
    for (const int child : node.children)
        appendNode(gltf, child, root_from_node, depth + 1, seen, mesh);
}

}  // namespace

Mesh loadMesh(const path& file) {
    const std::string bytes = readWholeFile(file, kMaxFileBytes);
    return parseMesh(file, {reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()});
}

Mesh parseMesh(const path& file, Bytes bytes) {
    const tinygltf::Model model = parse(file, bytes);
    if (model.scenes.empty()) throw DataError(file, "scenes", "there is none");
    const int scene = std::max(model.defaultScene, 0);
    if (std::size_t(scene) >= model.scenes.size()) throw DataError(file, "scene", "no such scene");
    Mesh mesh;
    std::vector<bool> seen(model.nodes.size());
    for (const int node : model.scenes[std::size_t(scene)].nodes)
        appendNode({file, model}, node, glm::dmat4(1.0), 0, seen, mesh);
    if (mesh.parts.empty()) throw DataError(file, "meshes", "there is none");
    return mesh;
}

Mesh unitTube(int sides) {
    Mesh mesh;
    const auto n = std::uint32_t(sides);
    for (std::uint32_t i = 0; i < n; ++i) {
        const float angle = 2.0f * std::numbers::pi_v<float> * float(i) / float(sides);
        const glm::vec3 out(std::cos(angle), std::sin(angle), 0.0f), up(0, 0, 1);
        for (const Vertex& v :
             {Vertex{out, out}, Vertex{out + up, out}, Vertex{out, -up}, Vertex{out + up, up}})
            mesh.vertices.push_back(v);
        const std::uint32_t a = 4 * i, b = 4 * ((i + 1) % n);
        for (const std::uint32_t index : {a, b, a + 1, a + 1, b, b + 1})
            mesh.indices.push_back(index);
        if (i > 0 && i + 1 < n)
            for (const std::uint32_t index : {2u, b + 2, a + 2, 3u, a + 3, b + 3})
                mesh.indices.push_back(index);
    }
    mesh.parts.push_back({.name = "tube", .node = "tube", .index_count = std::uint32_t(mesh.indices.size())});
    return mesh;
}

Mesh unitCone(int sides) {
    Mesh mesh;
    const auto n = std::uint32_t(sides);
    const glm::vec3 up(0, 0, 1);
    for (std::uint32_t i = 0; i < n; ++i) {
        const float angle = 2.0f * std::numbers::pi_v<float> * float(i) / float(sides);
        const glm::vec3 out(std::cos(angle), std::sin(angle), 0.0f);
        const glm::vec3 normal = glm::normalize(out + up);
        for (const Vertex& v : {Vertex{out, normal}, Vertex{up, normal}, Vertex{out, -up}})
            mesh.vertices.push_back(v);
        const std::uint32_t a = 3 * i, b = 3 * ((i + 1) % n);
        for (const std::uint32_t index : {a, b, a + 1})
            mesh.indices.push_back(index);
        if (i > 0 && i + 1 < n)
            for (const std::uint32_t index : {2u, b + 2, a + 2})
                mesh.indices.push_back(index);
    }
    mesh.parts.push_back({.name = "cone", .node = "cone", .index_count = std::uint32_t(mesh.indices.size())});
    return mesh;
}

Mesh unitRing(int sides, int tube_sides, float tube_radius) {
    Mesh mesh;
    const auto n = std::uint32_t(sides), m = std::uint32_t(tube_sides);
    const auto turn = [](std::uint32_t i, int of) {
        return 2.0f * std::numbers::pi_v<float> * float(i) / float(of);
    };
    for (std::uint32_t i = 0; i < n; ++i) {
        const glm::vec3 out(std::cos(turn(i, sides)), std::sin(turn(i, sides)), 0.0f);
        for (std::uint32_t j = 0; j < m; ++j) {
            const float angle = turn(j, tube_sides);
            const glm::vec3 normal = std::cos(angle) * out + std::sin(angle) * glm::vec3(0, 0, 1);
            mesh.vertices.push_back({out + tube_radius * normal, normal});
            const std::uint32_t a = m * i, b = m * ((i + 1) % n), k = (j + 1) % m;
            for (const std::uint32_t index : {a + j, b + j, a + k, a + k, b + j, b + k})
                mesh.indices.push_back(index);
        }
    }
    mesh.parts.push_back({.name = "ring", .node = "ring", .index_count = std::uint32_t(mesh.indices.size())});
    return mesh;
}

}  // namespace stylet::render
