#include "app/trainer/display/panels.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "app/trainer/attempt/staging.h"
#include "app/trainer/display/headset.h"

namespace stylet::trainer {

namespace {
constexpr double kAlert_m = 2.0;  // distance from the eyes
}

Panel::Panel(xr::Session& session, const render::Gpu& gpu, std::uint32_t width, std::uint32_t height)
    : session_(&session), id_(session.addPanel(width, height)), upload_(gpu, {width, height}) {}

bool Panel::show(const std::uint8_t* rgba, std::uint64_t revision) {
    if (id_ < 0) return false;
    if (revision != revision_)
        if (VkImage image = session_->acquirePanel(id_); image != VK_NULL_HANDLE) {
            upload_.write(image, vk::Format(session_->panelFormat()), rgba);
            session_->releasePanel(id_);
            revision_ = revision;
        }
    return revision_ != 0;
}

Pose NoticePlace::of(const Pose& stage_from_head) {
    const Vec3 forward = stage_from_head.direction({0.0, 0.0, -1.0});
    if (stage_from_panel_) {
        const Vec3 to_panel = glm::normalize(stage_from_panel_->position_m - stage_from_head.position_m);
        if (glm::dot(to_panel, forward) > std::cos(kTurnedAway_rad)) return *stage_from_panel_;
    }
    const Vec3 down = stage_from_head.direction({0.0, -1.0, 0.0});
    const Vec3 sight = std::cos(kBelow_rad) * forward + std::sin(kBelow_rad) * down;
    const Vec3 middle = stage_from_head.position_m + kDistance_m * sight;
    // stageFromEyes() looks along -z; a panel is visible from +z.
    stage_from_panel_ = {stageFromEyes(stage_from_head.position_m, middle).rotation, middle};
    return *stage_from_panel_;
}

HeadsetPanels::HeadsetPanels(xr::Session& session, const render::Gpu& gpu, double px_per_rad)
    : session_(&session), gpu_(&gpu), letter_rad_(letterAngle_rad(px_per_rad)) {}

void HeadsetPanels::placeScreens(render::RenderScene& scene, const render::ScreenPlaces& places,
                                 const render::VisibleScreens& seen) {
    placed_.clear();
    const std::array pictures{&scene.ultrasound_screen, &scene.xray_screen, &scene.monitor_screen};
    const std::array looked_at{seen.ultrasound, seen.xray, seen.monitor};
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        render::ScreenPicture& picture = *pictures[i];
        if (!looked_at[i] || picture.width == 0) continue;
        if (!screens_[i])
            screens_[i].emplace(*session_, *gpu_, std::uint32_t(picture.width),
                                std::uint32_t(picture.height));
        if (!screens_[i]->show(picture.rgba, picture.revision)) continue;
        picture.beneath = true;
        placed_.push_back(
            {&*screens_[i], places[i].stage_from_screen, places[i].width_m, places[i].height_m, true});
    }
}

void HeadsetPanels::placeNotice(const std::optional<Notice>& notice, const Pose& room_from_head) {
    if (!notice) return place_.forget();
    notice_.show(*notice);
    const int height = notice_.height();
    std::optional<Panel>& layer = notice_layers_[height == NoticePanel::kTallHeight ? 1 : 0];
    if (!layer) layer.emplace(*session_, *gpu_, NoticePanel::kWidth, std::uint32_t(height));
    if (!layer->show(notice_.rgba().data(), notice_.revision())) return;
    const double width_m = NoticePanel::width_m(NoticePlace::kDistance_m, letter_rad_);
    const double pixel_m = width_m / NoticePanel::kWidth;
    // The middle of the rows with text is at the notice's place.
    Pose place = place_.of(room_from_head);
    place.position_m += place.direction({0.0, 0.5 * (notice_.filledHeight() - height) * pixel_m, 0.0});
    placed_.push_back({&*layer, place, width_m, height * pixel_m, false});
}

bool HeadsetPanels::sees(const Vec3& stage_entry_m, const Pose& room_from_head) {
    if (!guide_place_) guide_place_ = guidePlace(stage_entry_m, room_from_head.position_m, letter_rad_);
    return inView(*guide_place_, room_from_head) &&
           !covers(*guide_place_, room_from_head.position_m, stage_entry_m);
}

void HeadsetPanels::placeGuide(const GuidePanel& guide) {
    if (guide.revision() == 0) return;
    if (!guide_layer_) guide_layer_.emplace(*session_, *gpu_, GuidePanel::kWidth, GuidePanel::kHeight);
    if (!guide_layer_->show(guide.rgba().data(), guide.revision())) return;
    placed_.push_back(
        {&*guide_layer_, guide_place_->stage_from_panel, guide_place_->width_m, guide_place_->height_m});
}

// The alert is head-locked and as large as the views of both eyes together, so that it is at the edge of the
// view in any gaze direction.
void HeadsetPanels::placeAlert(const std::optional<Alert>& alert, const std::array<render::View, 2>& views) {
    if (!alert) return;
    alert_.show(*alert);
    if (!alert_layer_) alert_layer_.emplace(*session_, *gpu_, AlertPicture::kSize, AlertPicture::kSize);
    if (!alert_layer_->show(alert_.rgba().data(), alert_.revision())) return;
    double left = 0.0, right = 0.0, up = 0.0, down = 0.0;  // tangents
    for (const render::View& view : views) {
        left = std::min(left, std::tan(double(view.angle_left)));
        right = std::max(right, std::tan(double(view.angle_right)));
        up = std::max(up, std::tan(double(view.angle_up)));
        down = std::min(down, std::tan(double(view.angle_down)));
    }
    const Vec3 middle{0.5 * (left + right), 0.5 * (up + down), -1.0};
    placed_.push_back({&*alert_layer_,
                       {Quat(1.0, 0.0, 0.0, 0.0), kAlert_m * middle},
                       kAlert_m * (right - left),
                       kAlert_m * (up - down),
                       false,
                       true});
}

std::span<const xr::ShownPanel> HeadsetPanels::shown(const Pose& stage_from_room) {
    shown_.clear();
    for (const Placed& p : placed_) {
        const Pose at = p.head_locked ? p.room_from_panel : stage_from_room * p.room_from_panel;
        xr::ShownPanel& panel = shown_.emplace_back();
        panel.id = p.panel->id();
        panel.stage_from_panel = at;
        panel.width_m = p.width_m, panel.height_m = p.height_m;
        panel.behind = p.behind;
        panel.head_locked = p.head_locked;
    }
    return shown_;
}

}  // namespace stylet::trainer
