#include "render/room/room.h"

#include <algorithm>

#include <glm/exponential.hpp>
#include <glm/packing.hpp>

#include "render/gpu/image_states.h"
#include "render/room/environment.h"
#include "render/scene/frame_bindings.h"
#include "render/scene/projection.h"

namespace stylet::render {
namespace {

constexpr std::uint32_t kShadowPixels = 1024;

// Uploads the environment map, which never changes: one layer per roughness.
GpuImage uploadEnvironment(const Gpu& gpu, const Environment& made) {
    constexpr std::uint32_t n = Environment::kSize;
    // Stores the square root in eight bits: a software rasteriser filters these several times faster than
    // half floats.
    std::vector<std::uint32_t> roots;
    roots.reserve(made.texels.size());
    for (const glm::vec3& light : made.texels)
        roots.push_back(glm::packUnorm4x8(glm::vec4(glm::sqrt(light / Environment::kBrightest), 1.0f)));
    const Buffer staging = makeFilledBuffer(gpu, roots, vk::BufferUsageFlagBits::eTransferSrc);
    GpuImage image(gpu, vk::Format::eR8G8B8A8Unorm, {n, n, 1}, Environment::kLevels,
                   vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferDst);
    submitAndWait(gpu, [&](const vk::raii::CommandBuffer& buffer) {
        recordUpload(buffer, staging, *image.handle, imagePart({n, n, 1}, Environment::kLevels), kUnused,
                     kFragmentRead);
    });
    return image;
}

}  // namespace

Room::Room(const Gpu& gpu, const std::filesystem::path& assets)
    : gpu_(&gpu),
      meshes_(gpu, assets),
      shadow_(gpu, kShadowPixels),
      screens_(gpu),
      smooth_(makeSampler(gpu, vk::Filter::eLinear, vk::SamplerAddressMode::eClampToEdge)),
      uniform_buffer_(gpu, sizeof(gpu::RoomUniforms), vk::BufferUsageFlagBits::eUniformBuffer) {
    const Environment made = makeEnvironment();
    environment_ = uploadEnvironment(gpu, made);
    for (std::size_t i = 0; i < made.irradiance.size(); ++i)
        uniforms_.irradiance[i] = glm::vec4(made.irradiance[i], 0.0f);
}

void Room::bind(Descriptors& descriptors) const {
    descriptors.bind(Binding::room, uniform_buffer_);
    descriptors.bind(Binding::environment, environment_, smooth_);
    descriptors.bind(Binding::lamp_shadow, shadow_.image(), shadow_.sampler());
    descriptors.bind(Binding::screens, screens_.image(), smooth_);
}

void Room::updateUniforms(const RenderScene& scene, const std::array<View, 2>& views,
                          const Placement& placed) {
    const Pose room_from_stage = placed.stage_from_room.inverse();
    const auto point = [&](const Vec3& stage) { return glm::vec3(room_from_stage * stage); };
    const auto direction = [&](const Vec3& stage) {
        return glm::vec3(glm::normalize(room_from_stage.direction(stage)));
    };
    uniforms_.room_from_stage = glm::mat4(toMatrix(room_from_stage));
    uniforms_.patient_from_room =
        glm::mat4(toMatrix(scene.stage_from_patient.inverse() * placed.stage_from_room));
    uniforms_.shadow_from_stage = shadow_.shadowFromStage();
    uniforms_.shadow_from_room =
        glm::mat4(glm::dmat4(shadow_.shadowFromStage()) * toMatrix(placed.stage_from_room));
    for (int eye = 0; eye < 2; ++eye)
        uniforms_.eyes[eye] = glm::vec4(point(views[std::size_t(eye)].stage_from_eye.position_m), 1.0f);
    const Vec3 beam = placed.lamp.field_m - placed.lamp.stage_m;
    uniforms_.lamp = scene.room.lamp
                         ? glm::vec4(point(placed.lamp.stage_m), 1.0f)
                         : glm::vec4(direction(scene.stage_from_patient.direction(kLampFromField)), 0.0f);
    uniforms_.beam = glm::vec4(direction(beam), float(glm::length(beam)));
    uniforms_.shell = toVec4(scene.room.shell_light);
    uniforms_.settings = {shadowed_ ? 1.0f : 0.0f, 0.0f, shadow_.texel(), 0.0f};
    std::fill(std::begin(uniforms_.contacts), std::end(uniforms_.contacts),
              glm::vec4(0.0f, 0.0f, -1.0f, -1.0f));
    std::copy(meshes_.contacts().begin(), meshes_.contacts().end(), uniforms_.contacts);
}

void Room::updateDrape(const RenderScene& scene, const PatientVolume* volume) {
    draped_ = scene.drape && scene.field_m && volume;
    if (!draped_) return;
    if (!drape_ || drape_->field() != *scene.field_m)
        drape_.emplace(*gpu_, volume->patient(), volume->backHeight(), *scene.field_m);
    drape_->breathe(scene.breath);
}

void Room::prepare(const RenderScene& scene, const std::array<View, 2>& views, const Skips& skips,
                   const PatientVolume* volume) {
    const Placement placed = computePlacement(scene, volume);
    updateDrape(scene, volume);
    meshes_.collectDraws(scene, placed, volume != nullptr, draped_ ? &drape_->model() : nullptr, views,
                         skips.unseen_parts);
    shadowed_ = scene.room.lamp && scene.room.lamp_lit;
    shadow_stale_ = shadowed_ && shadow_.aim(placed.lamp, meshes_.all(), skips.still_shadows);
    updateUniforms(scene, views, placed);
    screens_.update(scene, uniforms_);
    uniform_buffer_.write(&uniforms_, sizeof uniforms_);
}

VisibleScreens Room::visibleScreens(const RenderScene& scene, const std::array<View, 2>& views,
                                    const PatientVolume* volume) const {
    return meshes_.visibleScreens(scene, computePlacement(scene, volume), views);
}

ScreenPlaces Room::screenPlaces(const RenderScene& scene, const PatientVolume* volume) const {
    return meshes_.screenPlaces(computePlacement(scene, volume));
}

void Room::recordBefore(const vk::raii::CommandBuffer& buffer, vk::Pipeline caster,
                        const Descriptors& descriptors) const {
    screens_.record(buffer);
    if (shadow_stale_) shadow_.record(buffer, caster, descriptors, meshes_);
}

}  // namespace stylet::render
