#include "render/frame/uniforms.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include "render/room/placement.h"
#include "render/scene/projection.h"

namespace stylet::render {
namespace {

constexpr double kKeyStrength = 0.95;
constexpr double kCloseUp_voxels = 0.3;  // distance between rays at the nearest point of the patient's box
constexpr double kMinLayerScale = 0.25;
constexpr double kFinestStep = 0.5;  // smallest factor of the ray step when the head is close
constexpr double kTableHalfWidth_m = 0.34, kTableHalfLength_m = 0.85;

gpu::EyeUniforms eyeUniforms(const View& view, const RenderScene& scene, const RenderSettings& settings) {
    const glm::dmat4 stage_from_eye = toMatrix(view.stage_from_eye);
    return {.clip_from_stage = glm::mat4(clipFromEye(view, double(settings.near_m), double(settings.far_m)) *
                                         toMatrix(view.stage_from_eye.inverse())),
            .stage_from_eye = glm::mat4(stage_from_eye),
            .patient_from_eye = glm::mat4(toMatrix(scene.stage_from_patient.inverse() * view.stage_from_eye)),
            .tangents = {std::tan(view.angle_left), std::tan(view.angle_right), std::tan(view.angle_up),
                         std::tan(view.angle_down)}};
}

void describeVolume(gpu::FrameUniforms& frame, const PatientVolume& volume, float step_voxels,
                    const LookStyle& look) {
    const Grid& grid = volume.patient().grid();
    frame.grid_origin = toVec4(grid.origin_m, 1.0);
    frame.grid_spacing = toVec4(grid.spacing_m, double(step_voxels));
    frame.grid_dims = toVec4(Vec3(grid.dims), look.full_extinction_per_m);
    frame.brick_dims = toVec4(Vec3(volume.brickDims()));
    setMotion(frame, volume.deformed());
}

// In the order of MarkKind.
constexpr std::array kMarkKinds{gpu::kIncision, gpu::kPuncture, gpu::kBlood, gpu::kIodine};

void describeSurgery(gpu::FrameUniforms& frame, const RenderScene& scene) {
    const std::size_t cuts = std::min(scene.cuts.size(), std::size_t(gpu::kMaxCuts));
    for (std::size_t i = 0; i < cuts; ++i)
        frame.cuts[i] = toVec4(scene.cuts[i].normal, scene.cuts[i].offset_m);
    const std::size_t marks = std::min(scene.marks.size(), std::size_t(gpu::kMaxMarks));
    for (std::size_t i = 0; i < marks; ++i) {
        const Mark& mark = scene.marks[scene.marks.size() - marks + i];
        frame.marks[i] = {toVec4(mark.reference_m, mark.radius_m),
                          toVec4(mark.along, double(kMarkKinds[std::size_t(mark.kind)]))};
    }
    frame.layer.z = float(cuts), frame.layer.w = float(marks);
}

// Distance from a point to the box of voxels; 0 inside.
double distanceTo(const Grid& grid, const Vec3& p) {
    const Vec3 half = 0.5 * grid.spacing_m * Vec3(grid.dims);
    const Vec3 middle = grid.origin_m - 0.5 * grid.spacing_m + half;
    return glm::length(glm::max(glm::abs(p - middle) - half, Vec3(0.0)));
}

}  // namespace

vk::Extent2D layerExtent(const RenderScene& scene, const std::array<View, 2>& views,
                         const RenderSettings& settings, vk::Extent2D target, const Grid& grid) {
    double scale = double(std::clamp(settings.layer_scale, 0.1f, 1.0f));
    if (settings.close_up) {
        const double voxel = std::min({grid.spacing_m.x, grid.spacing_m.y, grid.spacing_m.z});
        double widest = 0.0;  // width of the layer in pixels for three rays per voxel
        for (const View& view : views) {
            const Vec3 eye = scene.stage_from_patient.inverse() * view.stage_from_eye.position_m;
            const double nearest = std::max(distanceTo(grid, eye), double(settings.near_m));
            const double across = std::tan(double(view.angle_right)) - std::tan(double(view.angle_left));
            widest = std::max(widest, across * nearest / (kCloseUp_voxels * voxel));
        }
        scale = std::min(scale, std::max(widest / target.width, kMinLayerScale));
    }
    const auto scaled = [&](std::uint32_t n) { return std::max(1u, std::uint32_t(std::lround(n * scale))); };
    return {scaled(target.width), scaled(target.height)};
}

gpu::FrameUniforms frameUniforms(const RenderScene& scene, const std::array<View, 2>& views,
                                 const RenderSettings& settings, const FrameExtents& extents,
                                 const PatientVolume* volume, const LookStyle& look) {
    const auto& [target, layer] = extents;
    gpu::FrameUniforms frame{};
    const Pose patient_from_stage = scene.stage_from_patient.inverse();
    for (int eye = 0; eye < 2; ++eye)
        frame.eyes[eye] = eyeUniforms(views[std::size_t(eye)], scene, settings);
    frame.patient_from_stage = glm::mat4(toMatrix(patient_from_stage));
    frame.target = {float(target.width), float(target.height), settings.near_m, settings.far_m};
    const double key = scene.room.lamp && !scene.room.lamp_lit ? 0.0 : kKeyStrength;
    frame.key_stage = toVec4(scene.stage_from_patient.direction(kLampFromField), key);
    frame.key_patient = toVec4(kLampFromField, key);
    frame.up_patient = toVec4(patient_from_stage.direction(Vec3(0, 1, 0)));
    frame.layer.x = float(layer.width), frame.layer.y = float(layer.height);
    if (!volume) return frame;
    // When the head is close, the layer has fewer rays. The time saved is spent on shorter steps, because
    // long ones would be visible.
    const double saved = double(layer.width) / (target.width * double(settings.layer_scale));
    const float step_voxels = settings.ray_step_voxels * float(std::clamp(saved, kFinestStep, 1.0));
    describeVolume(frame, *volume, step_voxels, look);
    describeSurgery(frame, scene);
    if (settings.foveation)
        frame.fovea = {settings.foveation->quarter, settings.foveation->sixteenth, 0.0f, 0.0f};
    frame.fovea.z = settings.far_steps ? 1.0f : 0.0f;
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
            .tint = glm::vec4(look.grazing_tint, look.gradient_voxels),
            .detail = {look.mottle, look.pores, 0.0f, 0.0f}};
}

}  // namespace stylet::render
