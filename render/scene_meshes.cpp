#include "render/scene_meshes.h"

#include <glm/gtc/quaternion.hpp>

#include "render/uniforms.h"

namespace stylet::render {
namespace {

constexpr int kTubeSides = 12;
constexpr double kPathRadius_m = 0.0006, kPathOutside_m = 0.045;
constexpr double kEntryRadius_m = 0.004, kEntryThickness_m = 0.0012;
constexpr glm::vec3 kPathColour{0.05f, 0.75f, 0.95f};

void addParts(std::vector<MeshDraw>& draws, const std::vector<MeshPart>& parts,
              const glm::mat4& stage_from_model) {
    for (const MeshPart& part : parts)
        draws.push_back({part.first_index,
                         part.index_count,
                         {.stage_from_model = stage_from_model,
                          .colour = glm::vec4(part.colour_linear, part.emission),
                          .material = glm::vec4(part.metallic, part.roughness, 0.0f, 0.0f)}});
}

glm::dmat4 scaled(glm::dmat4 m, const Vec3& scale) {
    for (int axis = 0; axis < 3; ++axis)
        m[axis] *= scale[axis];
    return m;
}

// A tube of `radius_m` from a to b.
glm::dmat4 tubeBetween(const Vec3& a, const Vec3& b, double radius_m) {
    const Vec3 along = b - a;
    const double length = glm::length(along);
    const Vec3 axis = along / length;
    const Vec3 side =
        glm::normalize(glm::cross(std::fabs(axis.x) < 0.9 ? Vec3(1, 0, 0) : Vec3(0, 1, 0), axis));
    glm::dmat4 m(1.0);
    m[0] = glm::dvec4(side * radius_m, 0.0);
    m[1] = glm::dvec4(glm::cross(axis, side) * radius_m, 0.0);
    m[2] = glm::dvec4(along, 0.0);
    m[3] = glm::dvec4(a, 1.0);
    return m;
}

}  // namespace

Pose patientFromTable(const PatientVolume& volume) {
    const patient::Grid& grid = volume.patient().grid();
    const Vec3 middle = grid.origin_m + 0.5 * grid.spacing_m * Vec3(grid.dims - 1);
    return {patient::Quat(1, 0, 0, 0), Vec3(middle.x, volume.backHeight(), middle.z)};
}

SceneMeshes::SceneMeshes(const Gpu& gpu, const std::filesystem::path& assets) {
    Mesh all;
    table_top_ = append(loadMesh(assets / "rooms" / "table_top.glb"), all);
    table_pedestal_ = append(loadMesh(assets / "rooms" / "table_pedestal.glb"), all);
    needle_ = append(loadMesh(assets / "instruments" / "needle.glb"), all);
    tube_ = append(unitTube(kTubeSides), all);
    const std::size_t vertex_bytes = all.vertices.size() * sizeof(Vertex),
                      index_bytes = all.indices.size() * 4;
    vertex_buffer_ = Buffer(gpu, vertex_bytes, vk::BufferUsageFlagBits::eVertexBuffer);
    vertex_buffer_.write(all.vertices.data(), vertex_bytes);
    index_buffer_ = Buffer(gpu, index_bytes, vk::BufferUsageFlagBits::eIndexBuffer);
    index_buffer_.write(all.indices.data(), index_bytes);
}

std::vector<MeshPart> SceneMeshes::append(const Mesh& mesh, Mesh& all) const {
    const auto vertex = std::uint32_t(all.vertices.size()), index = std::uint32_t(all.indices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const std::uint32_t i : mesh.indices)
        all.indices.push_back(vertex + i);
    std::vector<MeshPart> parts = mesh.parts;
    for (MeshPart& part : parts)
        part.first_index += index;
    return parts;
}

std::vector<MeshDraw> SceneMeshes::drawsOf(const RenderScene& scene, const PatientVolume* volume) const {
    std::vector<MeshDraw> draws;
    const glm::dmat4 stage_from_patient = matrixOf(scene.stage_from_patient);
    if (scene.table && volume) {
        const Pose stage_from_table = scene.stage_from_patient * patientFromTable(*volume);
        const double height = std::max(0.2, stage_from_table.position_m.y);
        addParts(draws, table_top_, glm::mat4(matrixOf(stage_from_table)));
        for (MeshDraw& draw : draws)
            draw.push.material.w = gpu::kShadowed;
        addParts(draws, table_pedestal_, glm::mat4(scaled(matrixOf(stage_from_table), Vec3(1, height, 1))));
    }
    if (scene.patient_from_needle) {
        const std::size_t first = draws.size();
        addParts(draws, needle_, glm::mat4(stage_from_patient * matrixOf(*scene.patient_from_needle)));
        for (std::size_t i = first; i < draws.size(); ++i)
            draws[i].push.material.w = gpu::kThin;
    }
    if (scene.reference_path_m) {
        const auto& [entry, target] = *scene.reference_path_m;
        const double length = glm::length(target - entry);
        if (length > 0.0) {
            const Vec3 out = (entry - target) / length;
            const std::size_t first = draws.size();
            addParts(draws, tube_,
                     glm::mat4(stage_from_patient *
                               tubeBetween(target, entry + out * kPathOutside_m, kPathRadius_m)));
            addParts(
                draws, tube_,
                glm::mat4(stage_from_patient * tubeBetween(entry - out * kEntryThickness_m,
                                                           entry + out * kEntryThickness_m, kEntryRadius_m)));
            for (std::size_t i = first; i < draws.size(); ++i)
                draws[i].push.colour = glm::vec4(kPathColour, 0.6f);
        }
    }
    return draws;
}

}  // namespace stylet::render
