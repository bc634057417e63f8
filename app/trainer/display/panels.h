// Flat pictures in the headset, each in an OpenXR layer of its own. That is sharper than drawing them into
// the eye images. The equipment screens lie beneath the eye images, which are transparent at the screens,
// so a hand in front of a screen hides it. The notice is in front of everything. Frame thread.
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
    // If the runtime refuses an image for it, the panel is never shown.
    Panel(xr::Session&, const render::Gpu&, std::uint32_t width, std::uint32_t height);
    // Uploads the picture if its revision changed and an image is free. Returns true if the layer shows
    // this picture or an earlier one.
    bool show(const std::uint8_t* rgba, std::uint64_t revision);
    int id() const { return id_; }

  private:
    xr::Session* session_;
    int id_;
    render::PictureUpload upload_;
    std::uint64_t revision_ = 0;  // shown by the layer
};

// Place of the notice: in front of the eyes and facing them. It stays there until the user turns away from
// it by more than kTurnedAway_rad.
class NoticePlace {
  public:
    static constexpr double kDistance_m = 1.0, kBelow_rad = 0.14, kTurnedAway_rad = 0.6;
    Pose of(const Pose& stage_from_head);
    void forget() { stage_from_panel_.reset(); }

  private:
    std::optional<Pose> stage_from_panel_;
};

class HeadsetPanels {
  public:
    HeadsetPanels(xr::Session&, const render::Gpu&, double px_per_rad);

    // Call first in a frame, before the scene is drawn. Starts a new list of panels and turns the visible
    // equipment screens into layers. `seen`: see render::Renderer::screensSeen. Poses are in the room
    // frame.
    void take(render::RenderScene&, const render::ScreenPlaces&, const render::ScreensSeen& seen);
    void take(const std::optional<Notice>&, const Pose& room_from_head);
    // True if the guide panel is in view and does not cover the entry. Only then is its picture uploaded.
    // The first call chooses the place of the panel; it stays there as long as this headset exists.
    bool sees(const Vec3& stage_entry_m, const Pose& room_from_head);
    void take(const GuidePanel&);
    void take(const std::optional<Alert>&, const std::array<render::View, 2>&);
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
    std::array<std::optional<Panel>, 3> screens_;  // created when first seen
    std::optional<Panel> notice_layer_;
    NoticePanel notice_;
    std::optional<Panel> guide_layer_, alert_layer_;
    std::optional<PanelPlace> guide_place_;
    AlertPicture alert_;
    NoticePlace place_;
    std::vector<Placed> placed_;
    std::vector<xr::ShownPanel> shown_;
};

}  // namespace stylet::trainer
