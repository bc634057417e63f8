// The room from anywhere: a renderer and a copy of the patient of its own, on its owner's device and thread.
#pragma once

#include <filesystem>
#include <optional>
#include <utility>

#include "app/trainer/scene.h"
#include "app/trainer/window/orbit.h"
#include "patient/planning.h"
#include "render/render.h"

namespace stylet::trainer {

struct CameraSettings {
    std::filesystem::path assets;
    render::Look look = render::Look::reveal;
    const haptics::TouchMap* touch = nullptr;  // as in PictureSettings
    double tick_s = 0.001;
    training::Hints hints{.ghost = true};  // as in SceneMaker
};

// One thread.
class CameraView {
  public:
    // All must outlive it. Throws render::GpuError, patient::DataError.
    CameraView(render::Gpu&, const patient::Patient&, const patient::PlannedPath&, const CameraSettings&);

    // Of a tick, without the machines' screens. Valid until the next call.
    render::RenderScene sceneOf(const Seen& seen) { return scenes_.sceneOf(seen); }
    void help(const training::Hints& hints) { scenes_.help(hints); }  // as SceneMaker
    // The operator's place where `camera` is absent.
    render::View view(const std::optional<Orbit>& camera, double aspect) const;
    // The resolution of the patient in it follows the time it takes. Valid until the next call.
    const render::Image& draw(const render::RenderScene&, const render::View&, std::uint32_t width,
                              std::uint32_t height);
    // Of a picture for a pane: more would take too long.
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

// What the operator sees from where he stands.
render::View operatorView(const patient::Pose& stage_from_patient, const patient::PlannedPath&,
                          double aspect);

// Where a camera begins: over the operator's shoulder.
Orbit startOrbit(const patient::Pose& stage_from_patient, const patient::PlannedPath&);

}  // namespace stylet::trainer
