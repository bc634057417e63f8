#include "app/trainer/window/camera_view.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/view/equipment_pictures.h"

namespace stylet::trainer {
namespace {

// Frame-time budget on a GPU and on a processor.
constexpr double kBudget_ms = 25.0, kProcessorBudget_ms = 160.0;
constexpr std::uint32_t kMaxPixels = 1600, kMaxProcessorPixels = 640;
constexpr double kHeadHalfHeight_rad = 0.56;  // half of the operator's vertical field of view
constexpr double kShoulder_rad = 0.65, kShoulderElevation_rad = 0.62, kShoulder_m = 0.95;

// Declares the whole second eye as hidden. The renderer draws two eyes, but only one is used.
void hideSecondEye(render::Renderer& renderer) {
    constexpr float kFar = 1000.0f;
    const std::array<glm::vec2, 4> corners{
        glm::vec2{-kFar, -kFar}, {kFar, -kFar}, {kFar, kFar}, {-kFar, kFar}};
    const std::array<std::uint32_t, 6> triangles{0, 1, 2, 0, 2, 3};
    renderer.setHiddenArea(1, corners, triangles);
}

}  // namespace

CameraView::CameraView(render::Gpu& gpu, const patient::Patient& patient, const patient::PlannedPath& path,
                       const PictureSettings& settings, const training::DifficultyRules& rules)
    : gpu_(&gpu),
      field_(settings.field),
      scenes_(patient, path, field_, sceneLook(settings.config), settings.press, rules),
      renderer_(gpu, {}, settings.assets),
      governor_(render::GovernorSettings{.budget_ms = gpu.isSoftware() ? kProcessorBudget_ms : kBudget_ms,
                                         .patience = 5}) {
    loadSceneLook(renderer_, settings.config);
    renderer_.setPatient(patient);
    hideSecondEye(renderer_);
}

render::View CameraView::view(const std::optional<Orbit>& camera, double aspect) const {
    if (camera) return orbitView(*camera, aspect);
    return operatorView(scenes_.stageFromPatient(), field_, aspect);
}

const render::Image& CameraView::draw(const render::RenderScene& scene, const render::View& view,
                                      std::uint32_t width, std::uint32_t height) {
    const auto begin = std::chrono::steady_clock::now();
    drawn_.layer_scale = governor_.layerScale();
    renderer_.setSettings(drawn_);
    image_ = std::move(renderer_.drawToImages(scene, {view, view}, width, height, &stats_)[0]);
    const double took_ms = msSince(begin);
    governor_.reportFrame(stats_.volume_ms, std::max(0.0, took_ms - stats_.volume_ms), stats_.layer_scale);
    return image_;
}

std::pair<std::uint32_t, std::uint32_t> CameraView::sizeFor(std::uint32_t width, std::uint32_t height) const {
    const std::uint32_t most = gpu_->isSoftware() ? kMaxProcessorPixels : kMaxPixels;
    const double scale = std::min(1.0, double(most) / std::max({width, height, 1u}));
    const auto edge = [&](std::uint32_t pixels) { return std::max(1u, std::uint32_t(scale * pixels + 0.5)); };
    return {edge(width), edge(height)};
}

render::View operatorView(const Pose& stage_from_patient, const OperativeField& field, double aspect) {
    const float up = float(kHeadHalfHeight_rad);
    const float right = float(std::atan(aspect * std::tan(kHeadHalfHeight_rad)));
    return {stageFromHead(stage_from_patient, field, 0.0), -right, right, up, -up};
}

Orbit startOrbit(const Pose& stage_from_patient, const OperativeField& field) {
    return {stage_from_patient * field.entry_m, kShoulder_rad, kShoulderElevation_rad, kShoulder_m};
}

}  // namespace stylet::trainer
