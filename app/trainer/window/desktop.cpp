// Pictures without a headset: the window takes its place. Drawn on the frame thread, shown on the window
// thread.
#include <chrono>
#include <memory>
#include <thread>

#include "app/trainer/view/first_picture.h"
#include "app/trainer/view/machine_pictures.h"
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
    std::vector<std::uint8_t> rgb;
    rgb.reserve(image.rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < image.rgba.size(); ++i)
        if (i % 4 != 3) rgb.push_back(image.rgba[i]);
    report::Canvas canvas(int(image.width), int(image.height), {});
    canvas.image(0, 0, int(image.width), int(image.height), rgb);
    canvas.savePng(file);
}

struct Desktop {
    Desktop(const patient::Patient&, const patient::PlannedPath&, const PictureSettings&);
    bool frame(const Seen&, const patient::ContrastTable*, const std::string& moment);
    void showMachines(render::RenderScene&, const Seen&, const patient::ContrastTable*,
                      const render::ScreensSeen&);
    void give(const Seen&, const FrameTime&);

    const PictureSettings settings;
    Mirror mirror;
    render::Gpu gpu;
    CameraView camera;
    MachinePictures machines;
    MirrorWants wants;
    render::ScreensSeen made;
    PictureTotals totals;
};

MirrorSettings mirrorOf(const PictureSettings& settings) {
    MirrorSettings mirror;
    mirror.assets = settings.assets;
    mirror.validation = settings.validation;
    mirror.look = settings.closed_look ? render::Look::closed : render::Look::reveal;
    mirror.touch = settings.touch, mirror.tick_s = settings.tick_s;
    mirror.desktop = true;
    mirror.hints = training::hintsOf(settings.difficulty);
    mirror.rearm_act = settings.rearm_act;
    mirror.port = settings.window;
    if (mirror.port && (mirror.port->takesWords() || mirror.port->replays()))
        mirror.width = 1440, mirror.height = 900;
    return mirror;
}

render::GpuSettings gpuOf(const PictureSettings& settings) {
    render::GpuSettings gpu;
    gpu.validation = settings.validation;
    gpu.pipeline_cache = settings.pipeline_cache.string();
    return gpu;
}

Desktop::Desktop(const patient::Patient& patient, const patient::PlannedPath& path,
                 const PictureSettings& settings_in)
    : settings(settings_in),
      mirror(patient, path, mirrorOf(settings)),
      gpu(gpuOf(settings)),
      camera(gpu, patient, path,
             {settings.assets, settings.closed_look ? render::Look::closed : render::Look::reveal,
              settings.touch, settings.tick_s, training::hintsOf(settings.difficulty)}),
      machines(gpu, camera.renderer().deformedPatient(), settings.assets) {
    totals.runtime = "none: a window";
    totals.gpu = gpu.name();
}

void Desktop::showMachines(render::RenderScene& scene, const Seen& seen,
                           const patient::ContrastTable* contrast, const render::ScreensSeen& screens) {
    made = screens;
    machines.show(momentOf(seen, scene, camera.renderer(), contrast, settings.guide, settings.tick_s), made);
    scene.ultrasound_screen = machines.ultrasoundScreen();
    scene.xray_screen = machines.xrayScreen();
}

bool Desktop::frame(const Seen& seen, const patient::ContrastTable* contrast, const std::string& moment) {
    MirrorChannels& channels = mirror.channels();
    if (!channels.open.load()) return false;
    channels.wants.read(wants);
    const auto begin = SteadyClock::now();
    const bool kept = !moment.empty(), room = wants.width > 0;
    ++totals.frames;
    if (kept || room || wants.ultrasound || wants.xray) {
        const auto [width, height] =
            kept ? std::pair{kMomentWidth, kMomentHeight} : camera.sizeFor(wants.width, wants.height);
        const render::View view = camera.view(kept ? std::nullopt : wants.camera, double(width) / height);
        camera.help(training::hintsOf(seen.difficulty.value_or(settings.difficulty)));
        render::RenderScene scene = camera.sceneOf(seen);
        // The room costs the most, so both equipment pictures are always drawn with it.
        showMachines(scene, seen, contrast, {.ultrasound = true, .xray = true});
        FrameTime time{seen.tick.tick};
        if (kept || room) {
            EyeGiven& eye = channels.eye.draft();
            eye.image = camera.draw(scene, view, width, height);
            if (kept) savePng(eye.image, settings.capture_folder / (moment + "_view.png"));
            if (kept) machines.save(settings.capture_folder, moment);
            if (room) channels.eye.publish();
            const render::RenderStats& stats = camera.stats();
            time.opaque_ms = stats.opaque_ms, time.volume_ms = stats.volume_ms;
            time.layer_scale = stats.layer_scale;
            ++totals.rendered;
            if (!totals.first) totals.first = firstPicture(gpu);
        }
        time.frame_ms = std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count();
        if (totals.times.size() < kMostFrameTimes) totals.times.push_back(time);
        give(seen, time);
    } else {
        give(seen, {seen.tick.tick});
    }
    std::this_thread::sleep_until(begin + kNothingToDraw);
    return true;
}

void Desktop::give(const Seen& seen, const FrameTime& time) {
    MirrorChannels& channels = mirror.channels();
    giveScreen(channels.ultrasound, machines.ultrasoundScreen(), made.ultrasound, 1);
    giveScreen(channels.xray, machines.xrayScreen(), made.xray, 1);
    giveState(channels, seen, settings.tick_s, time, Attention::focused, false);
}

PictureTotals totalsOf(const Desktop& desktop) {
    PictureTotals totals = desktop.totals;
    totals.validation_messages = desktop.gpu.validationMessages() + desktop.mirror.validationMessages();
    const MachineTotals& machines = desktop.machines.totals();
    totals.scans = machines.scans, totals.xray_pictures = machines.xray_pictures;
    totals.ultrasound_ms = machines.ultrasound_ms, totals.xray_ms = machines.xray_ms;
    return totals;
}

}  // namespace

std::optional<Pictures> openDesktop(const patient::Patient& patient, const patient::PlannedPath& path,
                                    const PictureSettings& settings, std::string& why_not) {
    try {
        // Shared because a std::function must be copyable; there is one owner.
        const auto desktop = std::make_shared<Desktop>(patient, path, settings);
        Pictures pictures;
        pictures.frame = [desktop](const Seen& seen, const patient::ContrastTable* contrast,
                                   const std::string& moment) {
            return desktop->frame(seen, contrast, moment);
        };
        pictures.totals = [desktop] { return totalsOf(*desktop); };
        pictures.ended = "the window was closed";
        return pictures;
    } catch (const std::runtime_error& e) {
        why_not = e.what();
        return std::nullopt;
    }
}

}  // namespace stylet::trainer
