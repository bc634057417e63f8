// Shows pictures in a window instead of a headset. They are drawn on the frame thread and shown on the window
// thread.
#include <chrono>
#include <memory>
#include <thread>

#include "app/trainer/view/equipment_pictures.h"
#include "app/trainer/view/first_picture.h"
#include "app/trainer/view/pictures.h"
#include "app/trainer/window/camera_view.h"
#include "app/trainer/window/mirror.h"
#include "app/trainer/window/mirror_feed.h"

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::uint32_t kMomentWidth = 960, kMomentHeight = 640;
constexpr auto kNothingToDraw = 16ms;

void savePng(const render::Image& image, const std::filesystem::path& file) {
    report::Canvas canvas(int(image.width), int(image.height), {});
    canvas.image(0, 0, int(image.width), int(image.height), rgbOf(image.rgba));
    canvas.savePng(file);
}

struct Desktop final : Display {
    Desktop(const patient::Patient&, const patient::PlannedPath&, const PictureSettings&);
    bool frame(const FrameState&, const patient::ContrastTable*, const std::string& moment) override;
    PictureTotals totals() const override;
    const char* endReason() const override { return "the window was closed"; }
    void showEquipment(render::RenderScene&, const FrameState&, const patient::ContrastTable*,
                       const render::VisibleScreens&);
    void publish(const FrameState&, const FrameTime&);

    const PictureSettings settings;
    Mirror mirror;
    render::Gpu gpu;
    CameraView camera;
    EquipmentPictures equipment_pictures;
    MirrorRequests requests;
    render::VisibleScreens made;
    PictureTotals counted;
};

MirrorSettings mirrorSettings(const PictureSettings& settings) {
    MirrorSettings mirror{.pictures = settings, .desktop = true};
    if (settings.window && (settings.window->acceptsCommands() || settings.window->replays()))
        mirror.width = 1440, mirror.height = 900;
    return mirror;
}

Desktop::Desktop(const patient::Patient& patient, const patient::PlannedPath& path,
                 const PictureSettings& settings_in)
    : settings(settings_in),
      mirror(patient, path, mirrorSettings(settings)),
      gpu({.validation = settings.config.validation, .pipeline_cache = settings.pipeline_cache}),
      camera(gpu, patient, path, settings, settings.config.startRules()),
      equipment_pictures(gpu, camera.renderer().deformedPatient(), settings.assets) {
    counted.runtime = "none: a window";
    counted.gpu = gpu.name();
}

void Desktop::showEquipment(render::RenderScene& scene, const FrameState& seen,
                            const patient::ContrastTable* contrast, const render::VisibleScreens& screens) {
    made = screens;
    equipment_pictures.show(makeImagingInput(seen, scene, camera.renderer(), contrast,
                                             settings.press.tools.guide, settings.press.tick_s),
                            made);
    scene.ultrasound_screen = equipment_pictures.ultrasoundScreen();
    scene.xray_screen = equipment_pictures.xrayScreen();
}

bool Desktop::frame(const FrameState& seen, const patient::ContrastTable* contrast,
                    const std::string& moment) {
    MirrorChannels& channels = mirror.channels();
    if (!channels.open.load()) return false;
    channels.requests.read(requests);
    const auto begin = SteadyClock::now();
    const bool kept = !moment.empty(), room = requests.width > 0;
    ++counted.frames;
    if (kept || room || requests.ultrasound || requests.xray) {
        const auto [width, height] =
            kept ? std::pair{kMomentWidth, kMomentHeight} : camera.sizeFor(requests.width, requests.height);
        const render::View view = camera.view(kept ? std::nullopt : requests.camera, double(width) / height);
        camera.help(settings.config.difficulties[seen.difficulty.value_or(settings.config.difficulty)]);
        render::RenderScene scene = camera.makeScene(seen);
        // The room costs the most time, so both equipment pictures are always drawn as well.
        showEquipment(scene, seen, contrast, {.ultrasound = true, .xray = true});
        FrameTime time{seen.tick.tick};
        if (kept || room) {
            EyeUpdate& eye = channels.eye.draft();
            eye.image = camera.draw(scene, view, width, height);
            if (kept) savePng(eye.image, settings.config.folder / (moment + "_view.png"));
            if (kept) equipment_pictures.save(settings.config.folder, moment);
            if (room) channels.eye.publish();
            const render::RenderStats& stats = camera.stats();
            time.opaque_ms = stats.opaque_ms, time.volume_ms = stats.volume_ms;
            time.layer_scale = stats.layer_scale;
            ++counted.rendered;
            if (!counted.first) counted.first = firstPicture(gpu);
        }
        time.frame_ms = msSince(begin);
        if (counted.times.size() < kMaxFrameTimes) counted.times.push_back(time);
        publish(seen, time);
    } else {
        publish(seen, {seen.tick.tick});
    }
    std::this_thread::sleep_until(begin + kNothingToDraw);
    return true;
}

void Desktop::publish(const FrameState& seen, const FrameTime& time) {
    MirrorChannels& channels = mirror.channels();
    publishScreen(channels.ultrasound, equipment_pictures.ultrasoundScreen(), made.ultrasound, 1);
    publishScreen(channels.xray, equipment_pictures.xrayScreen(), made.xray, 1);
    publishState(channels, {.seen = seen,
                            .tick_s = settings.press.tick_s,
                            .time = time,
                            .attention = Attention::focused,
                            .headset = false});
}

PictureTotals Desktop::totals() const {
    PictureTotals all = counted;
    all.validation_messages = gpu.validationMessages() + mirror.validationMessages();
    const EquipmentTotals& drawn = equipment_pictures.totals();
    all.scans = drawn.scans, all.xray_pictures = drawn.xray_pictures;
    all.ultrasound_ms = drawn.ultrasound_ms, all.xray_ms = drawn.xray_ms;
    return all;
}

}  // namespace

std::unique_ptr<Display> openDesktop(const patient::Patient& patient, const patient::PlannedPath& path,
                                     const PictureSettings& settings, std::string& why_not) {
    try {
        return std::make_unique<Desktop>(patient, path, settings);
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return nullptr;
    }
}

}  // namespace stylet::trainer
