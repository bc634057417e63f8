#include "app/trainer/figures/film_puncture.h"

#include <fmt/core.h>
#include <algorithm>

#include "app/report/film.h"
#include "app/trainer/view/contacts.h"

namespace stylet::trainer {
namespace {

using haptics::Phase;
using haptics::TickOutput;

constexpr double kBefore_s = 0.10, kAfter_s = 0.20;
constexpr int kTicksAFrame = 11;  // ticks between updates of the tissue: 90 Hz
constexpr double kAway_m = 0.06;

std::vector<TickOutput> ticksOf(const Attempt& attempt) {
    haptics::Simulation simulation(attempt.patient, attempt.simulation, attempt.touchMap(),
                                   attempt.ductSpace());
    const std::vector<haptics::TraceCommand>& commands = attempt.hand.commands;
    const double dt_ns = 1e9 * attempt.simulation.dt_s;
    std::vector<TickOutput> ticks;
    std::size_t cursor = 0, next = 0;
    haptics::NeedleEvents events;
    for (double t_ns = 0.0; t_ns <= double(attempt.hand.samples.back().t_ns); t_ns += dt_ns) {
        const haptics::TraceSample sample = haptics::sampleAt(attempt.hand, std::int64_t(t_ns), cursor);
        haptics::TickInput input;
        input.device = {sample.device_from_stylus, sample.buttons, 1};
        while (next < commands.size() && double(commands[next].t_ns) <= t_ns &&
               input.command_count < haptics::kMaxCommandsPerTick)
            input.commands[input.command_count++] = commands[next++].command;
        simulation.step(input, ticks.emplace_back(), events);
    }
    return ticks;
}

bool onWholeSkin(const TickOutput& out) {
    return out.phase == Phase::tenting && out.tissue == patient::Tissue::air;
}

// Returns the first tick after the puncture of the skin. If there is no puncture (the needle passes through
// an incision), returns the tick in which the skin is displaced most. Returns ticks.size() if nothing presses
// on the skin.
std::size_t middleOf(const Attempt& attempt, const std::vector<TickOutput>& ticks) {
    for (std::size_t i = 1; i < ticks.size(); ++i)
        if (onWholeSkin(ticks[i - 1]) && !onWholeSkin(ticks[i]) && ticks[i].phase != Phase::outside) return i;
    std::size_t most = ticks.size();
    double most_m = 0.0;
    for (std::size_t i = 0; i < ticks.size(); ++i)
        for (const patient::ToolContact& c :
             findContacts(ticks[i], attempt.patient, {attempt.touchMap(), attempt.simulation.tools}).all())
            if (glm::length(c.begin_moved_m) > most_m) most = i, most_m = glm::length(c.begin_moved_m);
    return most;
}

struct Shown {
    TickOutput tick;
    std::optional<patient::DisplacementTable> tool;
    std::string caption;
};

std::vector<Shown> framesAbout(const Attempt& attempt, const std::vector<TickOutput>& ticks, std::size_t cut,
                               int frames) {
    const double dt_s = attempt.simulation.dt_s;
    const auto ticksIn = [&](double s) { return std::size_t(s / dt_s); };
    const std::size_t begin = cut - std::min(cut, ticksIn(kBefore_s));
    const std::size_t end = std::min(ticks.size() - 1, cut + ticksIn(kAfter_s));
    ToolPress press(attempt.patient, {attempt.touchMap(), attempt.simulation.tools, dt_s});
    std::vector<Shown> shown;
    std::size_t followed = begin;
    for (int i = 0; i < frames; ++i) {
        const std::size_t at = begin + (end - begin) * std::size_t(i) / std::size_t(std::max(1, frames - 1));
        for (; followed < at; followed += kTicksAFrame)
            press.shown(ticks[followed]);
        const patient::DisplacementTable* table = press.shown(ticks[at]);
        const double moved_m =
            table ? glm::length(displacementAt(*table, ticks[at].patient_from_tool.position_m)) : 0.0;
        shown.push_back({ticks[at], table ? std::optional(*table) : std::nullopt,
                         fmt::format("{:+.3f} s   at the tip {:.2f} mm   {:.2f} N",
                                     (double(at) - double(cut)) * dt_s, 1e3 * moved_m, ticks[at].force_n)});
    }
    return shown;
}

}  // namespace

void writePuncture(const Attempt& attempt, const StereoView& view, int frames, const std::string& title,
                   const std::filesystem::path& out) {
    const std::vector<TickOutput> ticks = ticksOf(attempt);
    const std::size_t cut = middleOf(attempt, ticks);
    if (cut == ticks.size()) return;
    const std::vector<Shown> shown = framesAbout(attempt, ticks, cut, frames);
    std::array<std::vector<report::FilmFrame>, 2> looks;
    // Render all pictures of one look before the next, because each change of look reclassifies the volume.
    for (const bool closed : {true, false})
        for (const Shown& s : shown) {
            StereoShot shot{.breath = s.tick.breath, .closed = closed, .distance_m = kAway_m};
            if (haptics::isNeedleTool(s.tick.tool)) shot.patient_from_needle = s.tick.patient_from_needle;
            shot.tool = s.tool ? &*s.tool : nullptr;
            looks[closed ? 0 : 1].push_back(
                filmFrame(std::move(view.draw(shot)[0]), closed ? s.caption : ""));
        }
    std::vector<report::FilmFrame> both;
    for (std::size_t i = 0; i < shown.size(); ++i)
        both.push_back(report::sideBySide(looks[0][i], looks[1][i]));
    report::writeFilm(both, title + ", the skin before and after its cut", out, "puncture");
}

}  // namespace stylet::trainer
