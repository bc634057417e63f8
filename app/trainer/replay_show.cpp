#include "app/trainer/replay_show.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "app/installation.h"
#include "app/trainer/pictures.h"
#include "app/trainer/platform_linux.h"
#include "app/trainer/player.h"

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;

PictureSettings settingsFor(const ShownReplay& shown, const std::filesystem::path& out) {
    PictureSettings settings;
    settings.assets = assetsFolder();
    settings.pipeline_cache = cacheFolder() / "pipelines.bin";
    settings.capture_folder = out;
    settings.touch = shown.touch;
    settings.tick_s = shown.dt_s;
    settings.guide = shown.guide;
    settings.mirror = true;
    settings.window = std::make_shared<WindowPort>();
    settings.window->giveReplay();
    return settings;
}

Seen seenAt(const ShownReplay& shown, double tick) {
    Seen seen = shown.timeline.at(tick);
    if (!shown.ghost) return seen;
    const haptics::TickOutput& ghost = shown.ghost->at(tick).tick;
    if (haptics::holdsNeedle(ghost.tool)) seen.ghost_needle = ghost.patient_from_needle;
    return seen;
}

}  // namespace

Timeline::Timeline(std::size_t ticks) : every_(std::max<std::size_t>(5, ticks / kMost + 1)) {}

const Seen& Timeline::at(double tick) const {
    const auto after = std::upper_bound(seen_.begin(), seen_.end(), tick,
                                        [](double t, const Seen& s) { return t < double(s.tick.tick); });
    return after == seen_.begin() ? *after : *(after - 1);
}

void showReplay(const ShownReplay& shown, const std::vector<Moment>& moments,
                const std::filesystem::path& out) {
    const PictureSettings settings = settingsFor(shown, out);
    std::string why_not;
    const std::optional<Pictures> pictures = openDesktop(shown.patient, shown.path, settings, why_not);
    if (!pictures) throw patient::DataError("--show", "window", why_not);
    for (const Moment& moment : moments)
        pictures->frame(moment.seen, nullptr, moment.name);
    Player player(double(shown.ticks) * shown.dt_s);
    player.hear("toggle\n");
    auto last = SteadyClock::now();
    while (!interrupted()) {
        player.hear(settings.window->typed());
        const auto now = SteadyClock::now();
        player.pass(std::chrono::duration<double>(now - last).count());
        last = now;
        settings.window->tell(player.state());
        if (!pictures->frame(seenAt(shown, player.state().at_s / shown.dt_s), nullptr, "")) return;
    }
}

}  // namespace stylet::trainer
