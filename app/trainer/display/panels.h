// Flat pictures in the headset. Each has its own OpenXR layer, which is sharper than drawing it into the eye
// images. The equipment screens lie beneath the eye images, which are transparent where a screen is visible.
// A hand in front of a screen therefore hides it. The notice is in front of everything. Frame thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "app/trainer/session/alert.h"
#include "app/trainer/view/guide_panel.h"
#include "app/trainer/view/notice.h"
#include "render/render.h"
#include "xr/xr.h"

namespace stylet::trainer {

// One picture in its own layer.
class Panel {
  public:
    // If the runtime refuses to create an image for the panel, the panel is never shown.
    Panel(xr::Session&, const render::Gpu&, std::uint32_t width, std::uint32_t height);
    // Uploads the picture if its revision changed and an image is free. Returns true if the layer shows
    // this picture or an earlier one.
    bool show(const std::uint8_t* rgba, std::uint64_t revision);
    int id() const { return id_; }

  private:
    xr::Session* session_;
    int id_;
    render::PictureUpload upload_;
    std::uint64_t revision_ = 0;  // revision of the picture that the layer shows
};

// Place of the notice: in front of the eyes and facing them. It stays there until the user turns away from it
// by more than kTurnedAway_rad.
class NoticePlace {
  public:
    static constexpr double kDistance_m = 1.0, kBelow_rad = 0.24, kTurnedAway_rad = 0.6;
    Pose of(const Pose& stage_from_head);
    void forget() { stage_from_panel_.reset(); }

  private:
    std::optional<Pose> stage_from_panel_;
};

class HeadsetPanels {
  public:
    HeadsetPanels(xr::Session&, const render::Gpu&, double px_per_rad);

    // Call first in a frame, before the scene is drawn. Starts a new list of panels and turns the visible
    // equipment screens into layers. `seen`: see render::Renderer::visibleScreens. Poses are in the room
    // frame.
    void placeScreens(render::RenderScene&, const render::ScreenPlaces&, const render::VisibleScreens& seen);
    void placeNotice(const std::optional<Notice>&, const Pose& room_from_head);
    // Returns true if the guide panel is in view and does not cover the entry. Only then is its picture
    // uploaded. The first call chooses the panel's place, which does not change while this headset exists.
    bool sees(const Vec3& stage_entry_m, const Pose& room_from_head);
    void placeGuide(const GuidePanel&);
    void placeAlert(const std::optional<Alert>&, const std::array<render::View, 2>&);
    // Panels for xr::Session::endFrame. Valid until the next call.
    std::span<const xr::ShownPanel> shown(const Pose& stage_from_room);

  private:
    struct Placed {
        const Panel* panel = nullptr;
        Pose room_from_panel;
        double width_m = 0.0, height_m = 0.0;
        bool behind = false, head_locked = false;
    };
    xr::Session* session_;
    const render::Gpu* gpu_;
    double letter_rad_;
    std::array<std::optional<Panel>, 3> screens_;        // created when first seen
    std::array<std::optional<Panel>, 2> notice_layers_;  // low and tall
    NoticePanel notice_;
    std::optional<Panel> guide_layer_, alert_layer_;
    std::optional<PanelPlace> guide_place_;
    AlertPicture alert_;
    NoticePlace place_;
    std::vector<Placed> placed_;
    std::vector<xr::ShownPanel> shown_;
};

}  // namespace stylet::trainer
