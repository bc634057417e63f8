#include "app/trainer/run.h"

#include <cstdio>
#include <glm/geometric.hpp>
#include <set>

#include "app/installation.h"
#include "app/trainer/force_feed.h"
#include "app/trainer/hand.h"
#include "app/trainer/live_hand.h"
#include "app/trainer/patient_source.h"
#include "app/trainer/platform_linux.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

using patient::DataError;

namespace {

constexpr const char* kRuntimeVariable = "XR_RUNTIME_JSON";
constexpr const char* kScripted = "scripted";
constexpr const char* kReplay = "replay";

// The mock runtime's manifest beside this program: in a build tree, or installed.
std::filesystem::path bundledRuntime() {
    const std::filesystem::path lib = programFolder().parent_path() / "lib";
    for (const std::filesystem::path& file : {lib / "xrmock.json", lib / "stylet" / "xrmock.json"})
        if (std::filesystem::exists(file)) return file;
    return {};
}

records::RecordInfo recordInfo(const AttemptFacts& facts, const Scenario& scenario, double gain) {
    records::RecordInfo info;
    info.program_version = STYLET_VERSION;
    info.patient_folder = facts.patient_folder;
    info.patient_name = facts.patient_name;
    info.scenario = facts.scenario;
    info.moments = scenario.moments;
    info.approach_distance_m = scenario.approach_distance_m;
    info.seed = facts.seed;
    info.gain = gain;
    info.path = facts.path;
    return info;
}

std::string scenariosIn(const std::filesystem::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".toml") names.insert(entry.path().stem().string());
    std::string list;
    for (const std::string& name : names)
        list += (list.empty() ? "" : ", ") + name;
    return list;
}

bool isLive(const RunOptions& options) {
    return options.device != kScripted && options.device != kReplay;
}

// What goes together on the command line, before anything is made.
void checkHand(const RunOptions& options) {
    const auto refuse = [&](const char* option, const std::string& reason) {
        throw DataError(options.device, option, reason);
    };
    if (isLive(options) && options.fast) refuse("--fast", "a hand on a device moves in real time");
    if (!isLive(options) && options.seconds) refuse("--seconds", "only a hand on a device needs an end");
    if (options.device == kReplay && options.trace.empty()) refuse("--trace", "missing: the hand's CSV file");
    if (options.device != kReplay && !options.trace.empty()) refuse("--trace", "only for --device replay");
    if (isLive(options)) haptics::makeDriver(options.device, options.device_options, monotonicClock());
}

// The attempt as scripted, or with the hand of a trace in its place.
Attempt handOf(const RunOptions& options, Attempt attempt) {
    if (options.device == kReplay) attempt.hand = haptics::loadTrace(options.trace);
    return attempt;
}

// The user's device once it is ready.
std::unique_ptr<LiveDevice> readyDevice(const RunOptions& options, const haptics::Clock& clock) {
    catchInterrupts();
    auto live = std::make_unique<LiveDevice>(options.device, options.device_options, clock);
    if (!live->waitUntilReady(interrupted))
        throw DataError(options.device, "device", "given up before it was ready");
    return live;
}

// An attempt on the user's device, and how a tool is held where the device does not say it.
struct Live {
    std::unique_ptr<LiveDevice> device;
    haptics::HapticDevice* aimed = nullptr;  // of `device`
    patient::Quat device_from_needle{};
    haptics::GuideSettings guide;

    // In the device's axes, seen from a needle's tip.
    patient::Pose held(haptics::Tool tool) const { return heldLike({device_from_needle, {}}, tool, guide); }
};

Attempt liveAttempt(const RunOptions& options, Live& live, const patient::Patient& patient,
                    const Scenario& scenario, const patient::PlannedPath& path, const haptics::Clock& clock) {
    haptics::TouchMap touch = haptics::makeTouchMap(patient);  // first: a device that is ready may be moved
    live.device = readyDevice(options, clock);
    Attempt attempt = makeLiveAttempt(patient, scenario, path, options.seed, std::move(touch),
                                      live.device->profile(), live.device->grip(), options.rate_hz);
    haptics::SimulationSettings& settings = attempt.simulation;
    const patient::Pose needle = needlePose(path.entry_m, glm::normalize(path.target_m - path.entry_m));
    live.device_from_needle = settings.patient_from_device.inverse().rotation * needle.rotation;
    live.guide = settings.tools.guide;
    live.aimed = &live.device->aimed(live.held(scenario.tool));
    settings.profile = live.aimed->profile();
    return attempt;
}

LoopTotals runLive(const RunOptions& options, const Live& live, const Attempt& attempt, Session& session,
                   std::optional<Pictures> pictures, const haptics::Clock& clock) {
    const UserButtons buttons = live.device->buttons();
    sayOnStderr("the hand is yours, with the " +
                std::string(haptics::kToolNames[std::size_t(attempt.simulation.tools.first)]) +
                "; \"help\" and Enter list what can be said; " + describe(buttons) +
                (options.seconds ? "" : "; end with Ctrl-C"));
    const LiveHand hand{*live.aimed,
                        [&](double elapsed_s) {
                            live.device->tellNews();
                            return interrupted() || elapsed_s >= options.seconds.value_or(elapsed_s + 1.0);
                        },
                        [&] { return live.device->typed(); },
                        [&](haptics::Tool tool) { live.device->hold(live.held(tool)); },
                        buttons,
                        live.device->rearmAct()};
    session.setRearmButton(buttons.rearm);
    const LoopTotals totals = runRealTime(attempt, session, std::move(pictures), clock, &hand);
    live.device->stop();
    return totals;
}

}  // namespace

std::filesystem::path scenarioFile(const std::string& name) {
    if (name.ends_with(".toml")) return name;
    const std::filesystem::path folder = assetsFolder() / "scenarios", file = folder / (name + ".toml");
    if (std::filesystem::exists(file)) return file;
    throw DataError(folder, "scenario \"" + name + "\"", "not among: " + scenariosIn(folder));
}

std::optional<Pictures> picturesFor(const patient::Patient& patient, const patient::PlannedPath& path,
                                    const RunOptions& options) {
    if (options.fps.value_or(options.fast ? 0.0 : 1.0) <= 0.0) return std::nullopt;
    if (options.headless && environment(kRuntimeVariable).empty()) {
        const std::filesystem::path mock = bundledRuntime();
        if (!mock.empty()) setEnvironment(kRuntimeVariable, mock.string());
    }
    PictureSettings settings;
    settings.assets = assetsFolder();
    settings.capture_folder = options.out;
    settings.validation = options.validation;
    settings.virtual_clock = options.fast;
    std::string why_not;
    auto pictures = openPictures(patient, path, settings, why_not);
    if (!pictures)
        std::fprintf(stderr, "stylet: no pictures: %s; continuing without pictures\n", why_not.c_str());
    return pictures;
}

int run(const RunOptions& options) {
    checkHand(options);
    needFolder(options.out, "--out");
    const Scenario scenario = loadScenario(scenarioFile(options.scenario));
    const OpenedPatient opened = openPatient(
        {options.patient, options.seed, options.spacing_mm / 1000.0, cacheFolder(), assetsFolder()});
    const patient::Patient patient(opened.package);
    // Paths are planned for the breath that a commanded hold ends in: end-exhale.
    const patient::PlannedPath path = bestPath(patient, opened.folder, patient::Surrogate{});
    const haptics::Clock clock = monotonicClock();
    Live live;
    const Attempt attempt =
        isLive(options)
            ? liveAttempt(options, live, patient, scenario, path, clock)
            : handOf(options, makeAttempt(patient, scenario, path, options.seed, options.rate_hz));
    const AttemptFacts facts{opened.package.name,
                             opened.folder,
                             scenario.name,
                             options.seed,
                             options.fast ? "virtual" : "real time",
                             path,
                             attempt.simulation.dt_s,
                             options.device,
                             haptics::firmwareDigest(options.device_options)};

    auto pictures = picturesFor(patient, path, options);
    records::RecordWriter record(
        options.out / "record", {patient::digest(opened.package), attempt.simulation},
        recordInfo(facts, scenario,
                   haptics::outputGain(attempt.simulation.profile, attempt.simulation.output)));
    Session session(patient, path, scenario.moments, scenario.approach_distance_m, &record);
    const LoopTotals totals =
        live.device ? runLive(options, live, attempt, session, std::move(pictures), clock)
        : options.fast
            ? runFast(attempt, session, std::move(pictures), options.fps.value_or(0.0), workClock())
            : runRealTime(attempt, session, std::move(pictures), clock);
    record.finish();
    if (record.lost())
        std::fprintf(stderr, "stylet: the record ends at tick %llu: the next was lost to a full ring\n",
                     static_cast<unsigned long long>(record.lost()->first - 1));
    writeResults(patient, facts, session.log(), totals, options.out);
    printResults(facts, session.log(), totals, options.out, options.stats);
    return 0;
}

}  // namespace stylet::trainer
