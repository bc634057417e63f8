// Flat pictures of the headset's, as layers of their own: sharper than drawn into the eyes' pictures. The
// machines' screens lie beneath what is drawn, which leaves their glass clear, so that a hand before them
// hides them; the notice hangs before everything. Frame thread.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "app/trainer/alert.h"
#include "app/trainer/guide_panel.h"
#include "app/trainer/notice.h"
#include "render/render.h"
#include "xr/xr.h"

namespace stylet::trainer {

// A picture in a layer.
class Panel {
  public:
    // One that the runtime gives no image for is never shown.
    Panel(xr::Session&, const render::Gpu&, std::uint32_t width, std::uint32_t height);
    // Hands the picture over when its revision is another one and an image is free. True when the layer shows
    // this picture or one before it.
    bool show(const std::uint8_t* rgba, std::uint64_t revision);
    int id() const { return id_; }

  private:
    xr::Session* session_;
    int id_;
    render::PictureUpload upload_;
    std::uint64_t revision_ = 0;  // on the layer
};

// Where a notice hangs: before the eyes, turned to them, and it stays there until they have turned away from
// it.
class NoticePlace {
  public:
    static constexpr double kDistance_m = 1.0, kBelow_rad = 0.14, kTurnedAway_rad = 0.6;
    patient::Pose of(const patient::Pose& stage_from_head);
    void forget() { stage_from_panel_.reset(); }

  private:
    std::optional<patient::Pose> stage_from_panel_;
};

class HeadsetPanels {
  public:
    HeadsetPanels(xr::Session&, const render::Gpu&, double px_per_rad);

    // Before the scene is drawn: those of its screens that somebody sees become layers. `seen` as of
    // render::Renderer::screensSeen. Poses of the room.
    void take(render::RenderScene&, const render::ScreenPlaces&, const render::ScreensSeen& seen);
    void take(const std::optional<Notice>&, const patient::Pose& room_from_head);
    // Where it stands for as long as this headset is there; hidden while it would cover the entry. True when
    // it is in view: only then is its picture handed over.
    bool sees(const patient::Vec3& stage_entry_m, const patient::Pose& room_from_head);
    void take(const GuidePanel&);
    void take(const std::optional<Alert>&, const std::array<render::View, 2>&);
    // What xr::Session::endFrame is to show of it. Valid until the next take().
    std::span<const xr::ShownPanel> shown(const patient::Pose& stage_from_room);

  private:
    struct Placed {
        const Panel* panel = nullptr;
        patient::Pose room_from_panel;
        double width_m = 0.0, height_m = 0.0;
        bool behind = false, head_locked = false;
    };
    xr::Session* session_;
    const render::Gpu* gpu_;
    double letter_rad_;
    std::array<std::optional<Panel>, 3> screens_;  // made when first seen
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
