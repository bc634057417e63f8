// The operating room of a frame: equipment, light, shadows, and the pictures on its screens.
#pragma once

#include <optional>

#include "render/gpu/descriptors.h"
#include "render/room/drape.h"
#include "render/room/lamp_shadow.h"
#include "render/room/placement.h"
#include "render/room/scene_meshes.h"
#include "render/room/screens.h"
#include "render/volume/patient_volume.h"

namespace stylet::render {

class Room {
  public:
    Room(const Gpu&, const std::filesystem::path& assets);

    void bind(Descriptors&) const;
    // Call before the frame is recorded. `volume` may be null: then no table is drawn, because the table is
    // placed under a patient.
    void prepare(const RenderScene&, const std::array<View, 2>&, const Skips&, const PatientVolume* volume);
    // Call outside of any render pass, before the opaque one. `caster`: a pipeline that draws only depth.
    void recordBefore(const vk::raii::CommandBuffer&, vk::Pipeline caster, const Descriptors&) const;

    VisibleScreens visibleScreens(const RenderScene&, const std::array<View, 2>&, const PatientVolume*) const;
    ScreenPlaces screenPlaces(const RenderScene&, const PatientVolume*) const;

    const SceneMeshes& meshes() const { return meshes_; }
    // Null unless the drape is shown.
    const Drape* drape() const { return draped_ ? &*drape_ : nullptr; }
    // Call before the patient that the drape was made for is destroyed.
    void releasePatient() { drape_.reset(); }
    bool castsShadows() const { return shadowed_; }
    bool reusedShadow() const { return shadowed_ && !shadow_stale_; }

  private:
    void updateUniforms(const RenderScene&, const std::array<View, 2>&, const Placement&);

    void updateDrape(const RenderScene&, const PatientVolume*);

    const Gpu* gpu_;
    SceneMeshes meshes_;
    std::optional<Drape> drape_;
    LampShadow shadow_;
    Screens screens_;
    GpuImage environment_;
    vk::raii::Sampler smooth_;
    Buffer uniform_buffer_;
    gpu::RoomUniforms uniforms_{};
    bool draped_ = false, shadowed_ = false, shadow_stale_ = false;
};

}  // namespace stylet::render
