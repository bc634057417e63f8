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

struct Desktop final : Display {
    Desktop(const patient::Patient&, const patient::PlannedPath&, const PictureSettings&);
    bool frame(const Seen&, const patient::ContrastTable*, const std::string& moment) override;
    PictureTotals totals() const override;
    const char* endReason() const override { return "the window was closed"; }
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
    PictureTotals counted;
};

MirrorSettings mirrorSettings(const PictureSettings& settings) {
    MirrorSettings mirror{.pictures = settings, .desktop = true};
    if (settings.window && (settings.window->takesWords() || settings.window->replays()))
        mirror.width = 1440, mirror.height = 900;
    return mirror;
}

render::GpuSettings gpuOf(const PictureSettings& settings) {
    render::GpuSettings gpu;
    gpu.validation = settings.config.validation;
    gpu.pipeline_cache = settings.pipeline_cache.string();
    return gpu;
}

Desktop::Desktop(const patient::Patient& patient, const patient::PlannedPath& path,
                 const PictureSettings& settings_in)
    : settings(settings_in),
      mirror(patient, path, mirrorSettings(settings)),
      gpu(gpuOf(settings)),
      camera(gpu, patient, path, settings, training::hintsOf(settings.config.difficulty)),
      machines(gpu, camera.renderer().deformedPatient(), settings.assets) {
    counted.runtime = "none: a window";
    counted.gpu = gpu.name();
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
    ++counted.frames;
    if (kept || room || wants.ultrasound || wants.xray) {
        const auto [width, height] =
            kept ? std::pair{kMomentWidth, kMomentHeight} : camera.sizeFor(wants.width, wants.height);
        const render::View view = camera.view(kept ? std::nullopt : wants.camera, double(width) / height);
        camera.help(training::hintsOf(seen.difficulty.value_or(settings.config.difficulty)));
        render::RenderScene scene = camera.sceneOf(seen);
        // The room costs the most, so both equipment pictures are always drawn with it.
        showMachines(scene, seen, contrast, {.ultrasound = true, .xray = true});
        FrameTime time{seen.tick.tick};
        if (kept || room) {
            EyeGiven& eye = channels.eye.draft();
            eye.image = camera.draw(scene, view, width, height);
            if (kept) savePng(eye.image, settings.config.folder / (moment + "_view.png"));
            if (kept) machines.save(settings.config.folder, moment);
            if (room) channels.eye.publish();
            const render::RenderStats& stats = camera.stats();
            time.opaque_ms = stats.opaque_ms, time.volume_ms = stats.volume_ms;
            time.layer_scale = stats.layer_scale;
            ++counted.rendered;
            if (!counted.first) counted.first = firstPicture(gpu);
        }
        time.frame_ms = std::chrono::duration<double, std::milli>(SteadyClock::now() - begin).count();
        if (counted.times.size() < kMostFrameTimes) counted.times.push_back(time);
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
    giveState(channels, {.seen = seen,
                         .tick_s = settings.tick_s,
                         .time = time,
                         .attention = Attention::focused,
                         .headset = false});
}

PictureTotals Desktop::totals() const {
    PictureTotals all = counted;
    all.validation_messages = gpu.validationMessages() + mirror.validationMessages();
    const MachineTotals& drawn = machines.totals();
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
