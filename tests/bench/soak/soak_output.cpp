#include "tests/bench/soak/soak_output.h"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/installation.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/program/run.h"
#include "app/trainer/session/alert.h"
#include "app/trainer/sound/sounds.h"
#include "app/trainer/view/guide_panel.h"
#include "app/trainer/view/monitor.h"
#include "app/trainer/view/notice.h"

namespace stylet::soak {

namespace fs = std::filesystem;
using namespace trainer;

namespace {

constexpr int kEyePixels = 96;  // width and height; small because software rendering is slow
constexpr double kHints = 0.2;  // [fps] without a headset: only hints and alerts are updated
constexpr int kRecentred = 4;   // the frame at which the user recenters the view
constexpr int kLost = 12;       // the frame at which the runtime ends the session

void writeText(const fs::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text;
    out.close();
    if (!out) throw DataError(file, "document", "cannot be written");
}

// Returns a mock headset script. The head leans over the entry point and does not move. The user recenters
// at frame kRecentred and the session is lost at frame kLost.
std::string headset(const Pose& head) {
    using nlohmann::json;
    const Vec3& p = head.position_m;
    const Quat& q = head.rotation;
    const json script{
        {"version", 2},
        {"eyes",
         {{"ipd_m", kMockEyeDistance_m},
          {"recommended_size", {kEyePixels, kEyePixels}},
          {"left_fov_rad", kMockEyeAngles_rad[0]},
          {"right_fov_rad", kMockEyeAngles_rad[1]}}},
        {"head", {{{"t_s", 0}, {"position", {p.x, p.y, p.z}}, {"orientation", {q.x, q.y, q.z, q.w}}}}},
        {"events",
         {{{"frame", kRecentred}, {"recenter", json::object()}},
          {{"frame", kLost}, {"session_loss", {{"lost_after_s", 0}}}}}}};
    return script.dump(1) + '\n';
}

}  // namespace

void prepareUserOutput(const fs::path& folder, const patient::Patient& patient,
                       const patient::PlannedPath& path) {
    writeText(folder / "headset.json",
              headset(stageFromHead(stageFromPatient(patient, fieldOf(path)), fieldOf(path), 0.0)));
    setenv("XRMOCK_SCENARIO", (folder / "headset.json").c_str(), 1);
    setenv("XDG_CACHE_HOME", folder.c_str(), 1);  // compiled shaders
    // The sound is mixed as for a real device, in real time (wall clock), and discarded.
    writeText(folder / "sound.conf", "drivers = wave\n[wave]\nfile = /dev/null\n");
    setenv("ALSOFT_CONF", (folder / "sound.conf").c_str(), 1);
    setenv("ALSOFT_LOGLEVEL", "0", 0);
#ifdef STYLET_SOAK_PICTURES
    keepDriverLoaded();
#endif
}

struct UserOutput::Impl {
    Impl(const Context& context, Counts& counts_in)
        : counts(counts_in),
          tick_s(context.attempt.simulation.dt_s),
          fps(context.headset_fps > 0.0 ? context.headset_fps : kHints),
          difficulties(training::loadDifficulties(assetsFolder() / "difficulty.toml")),
          panel(difficulties[context.difficulty], training::kTypedControls, tick_s),
          alerts(tick_s),
          cues(soundPlaces(context.attempt.patient, fieldOf(context.path)), difficulties, context.difficulty,
               tick_s),
          sounds(cues.places().stage_from_operator, listener_pose, Speaker::device, context.log) {
        if (context.headset_fps > 0.0) room = openRoom(context);
    }
    std::unique_ptr<Display> openRoom(const Context& context) const {
        PictureSettings settings;
        settings.config.headless = settings.config.fast = true;
        settings.config.fps = context.headset_fps;
        settings.config.folder = context.folder;
        settings.config.difficulties = difficulties;
        settings.config.difficulty = context.difficulty;
        settings.listener_pose = listener_pose;
        settings.field = fieldOf(context.path);
        auto opened = picturesFor(context.attempt, context.path, std::move(settings));
        if (!opened) throw DataError("--pictures", "headset", "there is none");
        return opened;
    }
    void show(const FrameState& seen) {
        panel.update(seen, true);
        monitor.update(tick_s * double(seen.tick.tick), seen.tick.breath, seen.tick.breath_held);
        counts.alerts += alerts.update(seen).has_value();
        counts.alerts += makeNotice(seen, Attention::focused, "").has_value();
        ++counts.hints;
    }
    PictureTotals totalsOf(const Display& shown) const {
        const PictureTotals all = shown.totals();
        counts.frames += all.rendered, counts.headsets += 1 + all.headsets_found_again;
        counts.pictures += all.scans + all.xray_pictures;
        return all;
    }

    Counts& counts;
    const double tick_s;
    const double fps;
    const training::DifficultyTable difficulties;
    const std::shared_ptr<ListenerPose> listener_pose = std::make_shared<ListenerPose>();
    GuidePanel panel;
    AlertWatch alerts;
    BreathMonitor monitor;
    Cues cues;
    Sounds sounds;
    std::unique_ptr<Display> room;  // null: no headset; moved out by display()
};

UserOutput::UserOutput(const Context& context, Counts& counts)
    : impl_(std::make_unique<Impl>(context, counts)) {}

UserOutput::~UserOutput() {
    impl_->counts.sounds += impl_->sounds.totals().begun;
}

void UserOutput::playSounds(const FrameState& seen) {
    impl_->sounds.submit(impl_->cues.update(seen));
}

// Draws in the headset, if there is one. Also updates the parts that need no headset.
class UserOutput::SoakDisplay final : public Display {
  public:
    SoakDisplay(Impl& impl, std::function<void()> drawn)
        : impl_(&impl), room_(std::move(impl.room)), drawn_(std::move(drawn)) {}
    bool frame(const FrameState& seen, const patient::ContrastTable* contrast,
               const std::string& moment) override {
        impl_->show(seen);
        const bool goes_on = !room_ || room_->frame(seen, contrast, moment);
        drawn_();
        return goes_on;
    }
    PictureTotals totals() const override { return room_ ? impl_->totalsOf(*room_) : PictureTotals{}; }

  private:
    Impl* impl_;
    std::unique_ptr<Display> room_;
    std::function<void()> drawn_;
};

std::unique_ptr<Display> UserOutput::display(std::function<void()> drawn) {
    return std::make_unique<SoakDisplay>(*impl_, std::move(drawn));
}

double UserOutput::fps() const {
    return impl_->fps;
}

}  // namespace stylet::soak
