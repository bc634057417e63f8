#include "app/trainer/figures/film.h"

#include <fmt/core.h>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "app/installation.h"
#include "app/report/breath.h"
#include "app/report/film.h"
#include "app/trainer/attempt/attempt.h"
#include "app/trainer/attempt/scenario.h"
#include "app/trainer/figures/film_puncture.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "app/trainer/view/pictures.h"
#include "base/folder_linux.h"

namespace stylet::trainer {

using report::BreathSample;

namespace {

constexpr double kTick_s = 0.001;
constexpr int kTicksASample = 20;
constexpr double kBreathsAlone = 5.0;  // length of the film in breaths, if there is no script

// Breathing plan, breath commands and duration of a film.
struct Course {
    patient::BreathPlan plan;
    std::vector<haptics::TraceCommand> commands;
    double seconds = 0.0, breath_s = 0.0;
};

Course simulateCourse(const patient::Patient& patient, const Scenario& scenario,
                      const std::optional<patient::PlannedPath>& path, std::uint64_t seed) {
    Course course{breathPlan(patient.package(), scenario.breath, seed), {}, 0.0, 0.0};
    course.breath_s = scenario.breath.recording.empty()
                          ? course.plan.rhythm.period_s
                          : patient::loadRecordedBreath(scenario.breath.recording).period_s;
    course.seconds = kBreathsAlone * course.breath_s;
    if (path) {
        const haptics::Trace hand = makeAttempt(patient, scenario, *path, seed).hand;
        course.commands = hand.commands;
        course.seconds = 1e-9 * double(hand.samples.back().t_ns);
    }
    return course;
}

// Samples the breathing every `kTicksASample` ticks, including the scenario's breath-holds.
std::vector<BreathSample> breathe(const patient::Patient& patient, const Course& course, const Vec3& dome_m) {
    std::vector<BreathSample> samples;
    patient::BreathingState state;
    std::size_t next = 0;
    for (int tick = 0; tick * kTick_s <= course.seconds; ++tick) {
        if (tick % kTicksASample == 0) {
            const patient::Surrogate now = surrogateAt(state, course.plan, kTick_s);
            samples.push_back(
                {tick * kTick_s, now, state.held, report::domeBelowExhale_m(patient, now, dome_m)});
        }
        for (; next < course.commands.size() && 1e-9 * double(course.commands[next].t_ns) <= tick * kTick_s;
             ++next) {
            const haptics::CommandKind kind = course.commands[next].command.kind;
            if (kind == haptics::CommandKind::holdBreath || kind == haptics::CommandKind::breathe)
                commandHold(state, kind == haptics::CommandKind::holdBreath);
        }
        stepBreathing(state, course.plan, kTick_s);
    }
    return samples;
}

// Selects the samples that the film shows.
std::vector<BreathSample> selectFrames(const std::vector<BreathSample>& samples, int frames, double seconds) {
    std::vector<BreathSample> shown;
    for (int i = 0; i < frames; ++i) {
        const double t_s = seconds * i / frames;
        const auto at = std::size_t(std::lround(t_s / (kTicksASample * kTick_s)));
        shown.push_back(samples[std::min(at, samples.size() - 1)]);
    }
    return shown;
}

std::string makeCaption(const BreathSample& s) {
    return fmt::format("{:.2f} s   v {:.2f}   dome {:.1f} mm{}", s.t_s, s.breath.v, 1e3 * s.dome_m,
                       s.held ? "   held" : "");
}

void writeCoronal(const patient::Patient& patient, const std::vector<BreathSample>& shown, const Vec3& dome_m,
                  const std::string& title, const std::filesystem::path& out) {
    const Vec3 exhaled = deformedFromReference(patient.package().motion, {}, dome_m);
    std::vector<report::FilmFrame> frames;
    for (const BreathSample& s : shown) {
        frames.push_back(report::coronalFrame(patient, s.breath, exhaled.y, exhaled.z));
        frames.back().caption = makeCaption(s);
    }
    report::writeFilm(frames, title + ", coronal; dashed: the dome at end-exhale", out, "coronal");
}

void writeStereo(const patient::Patient& patient, const patient::PlannedPath& path,
                 const std::vector<BreathSample>& shown, const Scenario& scenario, const FilmOptions& options,
                 const std::string& title) {
    std::string why_not;
    const auto view = openStereo(patient, path, assetsFolder(), why_not);
    if (!view) {
        printMessage("no stereo view: " + why_not);
        return;
    }
    std::vector<report::FilmFrame> frames;
    for (const BreathSample& s : shown) {
        std::array<EyePicture, 2> eyes = view->draw({.breath = s.breath});
        frames.push_back(report::sideBySide(filmFrame(std::move(eyes[0]), makeCaption(s)),
                                            filmFrame(std::move(eyes[1]), {})));
    }
    report::writeFilm(frames, title + ", left and right eye", options.out, "stereo");
    writePuncture(makeAttempt(patient, scenario, path, options.source.seed), *view, options.frames, title,
                  options.out);
}

void printFollows(const std::vector<BreathSample>& samples) {
    const report::DomeRegression f = report::fitDomeMotion(samples);
    std::printf("  breathing: the dome travels %.1f mm, %.2f mm per v; r %.4f, beside the line %.2f mm\n",
                1e3 * f.travel_m, 1e3 * f.slope_m, f.correlation, 1e3 * f.residual_rms_m);
    if (f.held_from_m != f.held_to_m)
        std::printf("  held: the dome at %.1f to %.1f mm\n", 1e3 * f.held_from_m, 1e3 * f.held_to_m);
    std::printf("   t [s]       v   dome [mm]\n");
    constexpr std::size_t kRows = 25;
    for (std::size_t i = 0; i < kRows; ++i) {
        const BreathSample& s = samples[i * (samples.size() - 1) / (kRows - 1)];
        std::printf("  %6.2f  %6.3f  %10.2f%s\n", s.t_s, s.breath.v, 1e3 * s.dome_m, s.held ? "  held" : "");
    }
}

// Returns nothing if the patient has no labels for planning. The film then has no script and no stereo view.
std::optional<patient::PlannedPath> pathOf(const patient::Patient& patient, const OpenedPatient& opened) {
    try {
        return bestPath(patient, opened.folder, patient::Surrogate{});
    } catch (const DataError& e) {
        printMessage(
            fmt::format("no planned path, so the film has no breath-holds and no stereo view: {}", e.what()));
        return std::nullopt;
    }
}

}  // namespace

int film(const FilmOptions& options) {
    requireFolder(options.out, "--out");
    Scenario scenario = loadScenario(scenarioFile(options.scenario));
    if (!options.recording.empty()) breatheAsRecorded(scenario.breath, options.recording);
    const OpenedPatient opened = openPatient(options.source);
    const patient::Patient patient(opened.package);
    const std::optional<patient::PlannedPath> path = pathOf(patient, opened);
    const Course course = simulateCourse(patient, scenario, path, options.source.seed);
    const Vec3 dome_m = report::domePoint(patient);
    const std::vector<BreathSample> samples = breathe(patient, course, dome_m);
    const std::vector<BreathSample> shown =
        selectFrames(samples, options.frames, options.seconds.value_or(course.breath_s));

    const std::string signal = scenario.breath.recording.empty()
                                   ? "signal v"
                                   : "recorded v, " + scenario.breath.recording.stem().string();
    const std::string title = opened.package.name + ", scenario " + scenario.name;
    report::writeBreathCsv(samples, options.out / "breath.csv");
    report::drawBreath(samples, title, signal, options.out / "breath.png");
    writeCoronal(patient, shown, dome_m, title, options.out);
    if (path && options.stereo) writeStereo(patient, *path, shown, scenario, options, title);
    std::printf("%s\n", title.c_str());
    printFollows(samples);
    return 0;
}

}  // namespace stylet::trainer
