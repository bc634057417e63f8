// Draws the room from any viewpoint. It has its own renderer and copy of the patient, on its owner's device
// and thread.
#pragma once

#include <optional>
#include <utility>

#include "app/trainer/view/pictures.h"
#include "app/trainer/view/scene.h"
#include "app/trainer/window/orbit.h"
#include "patient/planning/planning.h"
#include "render/render.h"

namespace stylet::trainer {

// Use from one thread only.
class CameraView {
  public:
    // All arguments must outlive it. `hints`: see SceneMaker. Throws render::GpuError, DataError.
    CameraView(render::Gpu&, const patient::Patient&, const patient::PlannedPath&, const PictureSettings&,
               const training::Hints& hints);

    // Scene of a tick, without the equipment screens. Valid until the next call.
    render::RenderScene sceneOf(const Seen& seen) { return scenes_.sceneOf(seen); }
    void help(const training::Hints& hints) { scenes_.help(hints); }  // see SceneMaker
    // Without `camera`: the view from the operator's place.
    render::View view(const std::optional<Orbit>& camera, double aspect) const;
    // The resolution of the patient adapts to the frame time. Valid until the next call.
    const render::Image& draw(const render::RenderScene&, const render::View&, std::uint32_t width,
                              std::uint32_t height);
    // Picture size for a pane, limited because a larger picture would take too long.
    std::pair<std::uint32_t, std::uint32_t> sizeFor(std::uint32_t width, std::uint32_t height) const;
    render::Renderer& renderer() { return renderer_; }
    const render::RenderStats& stats() const { return stats_; }  // of the last picture

  private:
    const render::Gpu* gpu_;
    patient::PlannedPath path_;
    SceneMaker scenes_;
    render::Renderer renderer_;
    render::Governor governor_;
    render::RenderSettings drawn_;
    render::RenderStats stats_;
    render::Image image_;
};

// View from the operator's place.
render::View operatorView(const Pose& stage_from_patient, const patient::PlannedPath&, double aspect);

// Start of the free camera: over the operator's shoulder.
Orbit startOrbit(const Pose& stage_from_patient, const patient::PlannedPath&);

}  // namespace stylet::trainer
