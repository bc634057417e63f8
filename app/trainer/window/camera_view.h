// Draws the room from any viewpoint. It has its own renderer and its own copy of the patient, on the device
// and thread of its owner.
#pragma once

#include <optional>
#include <utility>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/view/pictures.h"
#include "app/trainer/view/scene.h"
#include "app/trainer/window/orbit.h"
#include "patient/planning/planning.h"
#include "render/render.h"

namespace stylet::trainer {

// Use from one thread only.
class CameraView {
  public:
    // All arguments must outlive this object. `rules`: see SceneMaker. Throws render::GpuError, DataError.
    CameraView(render::Gpu&, const patient::Patient&, const patient::PlannedPath&, const PictureSettings&,
               const training::DifficultyRules& rules);

    // Scene of a tick, without the equipment screens. Valid until the next call.
    render::RenderScene makeScene(const FrameState& seen) { return scenes_.makeScene(seen); }
    void help(const training::DifficultyRules& rules) { scenes_.help(rules); }  // see SceneMaker
    // Without `camera`, returns the view from the operator's place.
    render::View view(const std::optional<Orbit>& camera, double aspect) const;
    // Adapts the resolution of the patient to the frame time. The result is valid until the next call.
    const render::Image& draw(const render::RenderScene&, const render::View&, std::uint32_t width,
                              std::uint32_t height);
    // Returns the picture size for a pane. It is limited, because a larger picture would take too long.
    std::pair<std::uint32_t, std::uint32_t> sizeFor(std::uint32_t width, std::uint32_t height) const;
    render::Renderer& renderer() { return renderer_; }
    const render::RenderStats& stats() const { return stats_; }  // of the last picture

  private:
    const render::Gpu* gpu_;
    OperativeField field_;
    SceneMaker scenes_;
    render::Renderer renderer_;
    render::Governor governor_;
    render::RenderSettings drawn_;
    render::RenderStats stats_;
    render::Image image_;
};

// View from the operator's place.
render::View operatorView(const Pose& stage_from_patient, const OperativeField&, double aspect);

// Start position of the free camera: over the operator's shoulder.
Orbit startOrbit(const Pose& stage_from_patient, const OperativeField&);

}  // namespace stylet::trainer
