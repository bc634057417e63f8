// Content of the window: views, panes, pictures, captions. Window thread.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "app/report/canvas.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/session/alert.h"
#include "app/trainer/view/guide_panel.h"
#include "app/trainer/view/notice.h"
#include "app/trainer/window/app_window.h"
#include "app/trainer/window/camera_view.h"
#include "app/trainer/window/layout.h"
#include "app/trainer/window/metrics.h"
#include "app/trainer/window/mirror.h"
#include "app/trainer/window/slice_view.h"
#include "app/trainer/window/window_keys.h"

namespace stylet::trainer {

// Caption of the ultrasound or the X-ray pane. `age_s`: time since its picture was last up to date; none:
// there is no picture yet.
std::string screenCaption(WindowView, const training::Equipment&, std::optional<double> age_s);
// Text in place of the picture of such a pane.
std::string missingPictureText(WindowView, const training::Equipment&);

class WindowContent {
  public:
    // All arguments must outlive this object.
    WindowContent(const patient::Patient&, const patient::PlannedPath&, const MirrorSettings&,
                  MirrorChannels&, render::Gpu&, render::Presenter&);

    // Handles keys and mouse. Returns true if the window size is unchanged.
    bool handleEvents(const WindowEvents&);
    // Reads new data, publishes requests and draws the panes that belong to this thread. Returns true if
    // there is something new to present.
    bool update();
    // Presents the result of update(). May wait for the display. Returns false if the display is not ready;
    // the caller then tries again.
    bool present();
    std::string title() const;

  private:
    using Clock = std::chrono::steady_clock;
    // Picture ids of the presenter.
    enum Picture : std::size_t {
        kChrome,
        kEye,
        kCamera,
        kUltrasound,
        kXray,
        kMetrics,
        kSlices,
        kGuide,
        kNotice
    };
    struct Shown {
        int width = 0, height = 0;  // 0: no picture yet
    };

    // A view that this thread draws on a canvas.
    struct PaneCanvas {
        std::unique_ptr<report::Canvas> canvas{};
        bool stale = true;
        Clock::time_point drawn{};
    };

    bool isReplay() const { return settings_.pictures.window && settings_.pictures.window->replays(); }
    bool hasToolInput() const {
        return settings_.pictures.window && settings_.pictures.window->hasToolInput();
    }
    bool offered(WindowView) const;
    const Pane* findPane(WindowView) const;
    void select(WindowView);
    void arrange();
    int otherKeyRows() const { return isReplay() ? 2 : 1; }  // the row of the views, and a replay's bar
    void updateKeyRows();
    void handleKey(const KeyPress&);
    void moveTool(const WindowEvents&);
    void scrub(const std::vector<Drag>&);
    Rect barRect() const;
    std::string playbackText() const;
    std::string answerText() const;
    void drawBar(report::Canvas&) const;
    void moveToolBy(const KeyPress&);
    std::optional<MouseMove> dragMotion(const Drag&) const;
    MouseMove inOperatorsView(double right, double up, bool turns) const;
    void publishRequests();
    bool readPictures();
    void help(training::Difficulty);
    void updateHints(const FrameState&);
    bool drawCamera();
    template <typename Draw>
    bool drawPane(WindowView, PaneCanvas&, std::chrono::milliseconds period, const Draw&);
    bool drawMetrics();
    bool drawSlices();
    bool drawGuide();
    bool drawNotice();
    void drawAlert(report::Canvas&) const;
    bool showsHidden() const;
    training::DifficultyRules instructorsRules() const;
    void drawKeys(report::Canvas&) const;
    bool drawChrome();
    std::string makeCaption(WindowView) const;
    std::string emptyText(WindowView) const;
    void place(Picture, WindowView);
    void placeNotice();
    Picture pictureId(WindowView) const;

    const patient::Patient* patient_;
    const patient::PlannedPath path_;
    const OperativeField field_;
    const Pose stage_from_patient_;
    const MirrorSettings settings_;
    training::DifficultyRules rules_;  // rules of the current difficulty
    std::optional<training::Difficulty> difficulty_;
    MirrorChannels* channels_;
    render::Gpu* gpu_;
    render::Presenter* presenter_;
    WindowView view_ = WindowView::overview, main_ = WindowView::leftEye;
    Layout layout_;
    std::uint32_t width_ = 0, height_ = 0;
    std::array<Shown, 9> shown_{};
    int eye_given_ = -1;
    std::pair<std::uint64_t, std::uint64_t> ultrasound_uploaded_{}, xray_uploaded_{};
    std::optional<Orbit> orbit_;
    std::optional<CameraView> camera_;
    bool camera_failed_ = false, camera_stale_ = true;
    std::string chrome_key_;  // describes the content for which the chrome was drawn
    std::unique_ptr<report::Canvas> chrome_;
    PaneCanvas metrics_pane_, slices_pane_;
    Metrics metrics_;
    SliceView slices_;
    std::optional<GuidePanel> guide_;  // present while the difficulty allows it
    std::uint64_t guide_shown_ = 0;
    NoticePanel notice_;
    std::uint64_t notice_shown_ = 0;
    bool noticed_ = false;  // a notice is shown now
    AlertWatch alerts_;
    std::optional<Alert> alert_;
    Rect frame_{};  // around the first pane; the alert is drawn in it
    std::uint64_t tick_ = 0;
    WindowKeys keys_;
    WindowKeys::HelpRows help_, key_rows_;         // the key help; the part that is shown
    std::array<std::uint32_t, 3> key_rows_fit_{};  // width, height and page of key_rows_
    std::uint32_t help_page_ = 0;
    report::Canvas measure_{1, 1, {}};  // for widths of texts
    Playback playback_;                 // playback state of a replay
    double scrubbed_px_ = 0.0;
    bool state_known_ = false;
    std::vector<std::uint8_t> pixels_;
    std::vector<render::PlacedPicture> placed_;
    bool stale_ = true;
};

}  // namespace stylet::trainer
