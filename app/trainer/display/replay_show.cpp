#include "app/trainer/display/replay_show.h"

#include <fmt/core.h>
#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "app/installation.h"
#include "app/trainer/display/player.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/trainer/view/pictures.h"

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;

PictureSettings pictureSettings(const ShownReplay& shown, const std::filesystem::path& out) {
    PictureSettings settings;
    settings.assets = assetsFolder();
    settings.pipeline_cache = cacheFolder() / "pipelines.bin";
    settings.config.folder = out;
    settings.press = shown.press;
    settings.field = fieldOf(shown.path);
    settings.config.difficulties = training::loadDifficulties(settings.assets / "difficulty.toml");
    settings.config.mirror = !environment("DISPLAY").empty();
    settings.window = std::make_shared<WindowPort>();
    settings.window->enableReplay();
    settings.controllers = std::make_shared<ControllerPort>();
    return settings;
}

FrameState seenAt(const ShownReplay& shown, double tick) {
    FrameState seen = shown.timeline.at(tick);
    if (!shown.ghost) return seen;
    const FrameState& ghost = shown.ghost->at(tick);
    if (haptics::isNeedleTool(ghost.tick.tool))
        seen.ghost_tool = {ghost.tick.tool, ghost.tick.patient_from_needle, ghost.needle.length_m};
    return seen;
}

// Opens a headset if there is one, else a window.
std::unique_ptr<Display> openDisplay(const ShownReplay& shown, const PictureSettings& settings) {
    std::string no_headset, no_window;
    if (!shown.window)
        if (auto pictures = openPictures(shown.patient, shown.path, settings, no_headset)) return pictures;
    auto pictures = openDesktop(shown.patient, shown.path, settings, no_window);
    if (!pictures)
        throw EnvironmentError("--show needs a headset or a window: " + no_window +
                               (no_headset.empty() ? "" : "; " + no_headset));
    if (!no_headset.empty()) printMessage("no headset: " + no_headset + "; using a window instead");
    return pictures;
}

}  // namespace

Timeline::Timeline(std::size_t ticks) : every_(std::max<std::size_t>(5, ticks / kMaxStates + 1)) {}

const FrameState& Timeline::at(double tick) const {
    const auto after = std::upper_bound(seen_.begin(), seen_.end(), tick, [](double t, const FrameState& s) {
        return t < double(s.tick.tick);
    });
    return after == seen_.begin() ? *after : *(after - 1);
}

void showReplay(const ShownReplay& shown, const std::vector<Capture>& captures,
                const std::filesystem::path& out) {
    const PictureSettings settings = pictureSettings(shown, out);
    const std::unique_ptr<Display> display = openDisplay(shown, settings);
    for (const Capture& capture : captures)
        display->frame(capture.state, nullptr, capture.name);
    Player player(double(shown.ticks) * shown.press.tick_s);
    if (shown.at_s) {
        player.execute("seek " + std::to_string(*shown.at_s / player.state().length_s) + "\n");
        display->frame(seenAt(shown, player.state().at_s / shown.press.tick_s), nullptr, "at");
    } else {
        player.execute("toggle\n");
    }
    PlayerStick stick;
    auto last = SteadyClock::now();
    bool goes_on = true;
    while (goes_on && !interrupted()) {
        const auto now = SteadyClock::now();
        const double dt_s = std::chrono::duration<double>(now - last).count();
        last = now;
        const ControllerPort::Frame hand = settings.controllers->frame();
        player.execute(settings.window->typed() + stick.update(hand.buttons, hand.thumbstick, dt_s));
        // Stop when the headset is taken off, so that the user misses nothing.
        if (display->attention() == Attention::away) player.execute("stop\n");
        player.advance(dt_s);
        settings.window->publish(player.state());
        goes_on = display->frame(seenAt(shown, player.state().at_s / shown.press.tick_s), nullptr, "");
    }
    printMessage(
        fmt::format("the replay ended at {:.6f} of {:.6f} s", player.state().at_s, player.state().length_s));
}

}  // namespace stylet::trainer
