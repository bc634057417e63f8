#include "render/uniforms.h"

#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "render/scene_meshes.h"

namespace stylet::render {
namespace {

constexpr float kKeyStrength = 0.95f;
const Vec3 kKeyFromPatient = glm::normalize(Vec3(0.45, 0.9, 0.15));  // the lamp hangs over the right flank
constexpr double kTableHalfWidth_m = 0.34, kTableHalfLength_m = 0.85;

gpu::EyeUniforms eyeUniforms(const View& view, const RenderScene& scene, const RenderSettings& settings) {
    const glm::dmat4 stage_from_eye = matrixOf(view.stage_from_eye);
    return {.clip_from_stage = glm::mat4(clipFromEye(view, double(settings.near_m), double(settings.far_m)) *
                                         matrixOf(view.stage_from_eye.inverse())),
            .stage_from_eye = glm::mat4(stage_from_eye),
            .patient_from_eye = glm::mat4(matrixOf(scene.stage_from_patient.inverse() * view.stage_from_eye)),
            .tangents = {std::tan(view.angle_left), std::tan(view.angle_right), std::tan(view.angle_up),
                         std::tan(view.angle_down)}};
}

void describeVolume(gpu::FrameUniforms& frame, const PatientVolume& volume, const RenderSettings& settings,
                    const LookStyle& look) {
    const patient::Grid& grid = volume.patient().grid();
    const patient::Grid& tables = volume.deformation();
    // A node lies in the middle of its texel.
    const Vec3 scale = 1.0 / (tables.spacing_m * Vec3(tables.dims));
    frame.grid_origin = glm::vec4(glm::vec3(grid.origin_m), 1.0f);
    frame.grid_spacing = glm::vec4(glm::vec3(grid.spacing_m), settings.ray_step_voxels);
    frame.grid_dims = glm::vec4(glm::vec3(grid.dims), float(look.full_extinction_per_m));
    frame.brick_dims = glm::vec4(glm::vec3(volume.brickDims()), 0.0f);
    frame.deform_scale = glm::vec4(glm::vec3(scale), 0.0f);
    frame.deform_offset = glm::vec4(glm::vec3(0.5 / Vec3(tables.dims) - tables.origin_m * scale), 0.0f);
}

}  // namespace

glm::dmat4 matrixOf(const Pose& pose) {
    glm::dmat4 m = glm::mat4_cast(pose.rotation);
    m[3] = glm::dvec4(pose.position_m, 1.0);
    return m;
}

glm::dmat4 clipFromEye(const View& view, double near_m, double far_m) {
    const double left = std::tan(double(view.angle_left)), right = std::tan(double(view.angle_right));
    const double up = std::tan(double(view.angle_up)), down = std::tan(double(view.angle_down));
    glm::dmat4 m(0.0);
    m[0][0] = 2.0 / (right - left);
    m[2][0] = (right + left) / (right - left);
    m[1][1] = -2.0 / (up - down);  // Vulkan's y points down
    m[2][1] = -(up + down) / (up - down);
    m[2][2] = near_m / (far_m - near_m);
    m[3][2] = near_m * far_m / (far_m - near_m);
    m[2][3] = -1.0;
    return m;
}

gpu::FrameUniforms frameUniforms(const RenderScene& scene, const std::array<View, 2>& views,
                                 const RenderSettings& settings, std::uint32_t width, std::uint32_t height,
                                 const PatientVolume* volume, const LookStyle& look) {
    gpu::FrameUniforms frame{};
    const Pose patient_from_stage = scene.stage_from_patient.inverse();
    for (int eye = 0; eye < 2; ++eye)
        frame.eyes[eye] = eyeUniforms(views[std::size_t(eye)], scene, settings);
    frame.patient_from_stage = glm::mat4(matrixOf(patient_from_stage));
    frame.target = {float(width), float(height), settings.near_m, settings.far_m};
    frame.key_stage = glm::vec4(glm::vec3(scene.stage_from_patient.direction(kKeyFromPatient)), kKeyStrength);
    frame.key_patient = glm::vec4(glm::vec3(kKeyFromPatient), kKeyStrength);
    frame.up_patient = glm::vec4(glm::vec3(patient_from_stage.direction(Vec3(0, 1, 0))), 0.0f);
    if (!volume) return frame;
    describeVolume(frame, *volume, settings, look);
    if (scene.table) {
        const Pose stage_from_table = scene.stage_from_patient * patientFromTable(*volume);
        const Vec3 axis = stage_from_table.direction(Vec3(0, 0, 1));
        const Vec3 flat = glm::normalize(Vec3(axis.x, 0.0, axis.z) + Vec3(0, 0, 1e-9));
        frame.shadow_stage = {float(stage_from_table.position_m.x), float(stage_from_table.position_m.z),
                              float(kTableHalfWidth_m), float(kTableHalfLength_m)};
        frame.shadow_axis_stage = {float(flat.x), float(flat.z), 0.0f, 0.0f};
    }
    return frame;
}

gpu::LookUniforms lookUniforms(const LookStyle& look) {
    return {.surface = {look.wrap, look.specular, look.specular_power, look.rim},
            .tint = glm::vec4(look.grazing_tint, look.gradient_voxels)};
}

}  // namespace stylet::render
