#include "app/trainer/program/run.h"

#include <cstdio>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "app/installation.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/reference_path.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/attempt/scenario.h"
#include "app/trainer/attempt/staging.h"
#include "app/trainer/hands/live_hand.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/hands/tipped_device.h"
#include "app/trainer/loop/force_feed.h"
#include "app/trainer/loop/loops.h"
#include "app/trainer/program/results.h"
#include "app/trainer/session/keeper.h"
#include "app/trainer/session/rest.h"
#include "app/trainer/sound/sounds.h"
#include "app/trainer/stores/patient_source.h"
#include "app/trainer/stores/platform_linux.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

namespace {

constexpr const char* kRuntimeVariable = "XR_RUNTIME_JSON";
constexpr const char* kDisplayVariable = "DISPLAY";
constexpr const char* kSoundLogVariable = "ALSOFT_LOGLEVEL";
constexpr const char* kScripted = "scripted";

// Manifest of the mock runtime, in this program's build tree or installed with it.
std::filesystem::path bundledRuntime() {
    const std::filesystem::path prefix = programFolder().parent_path();
    for (const std::filesystem::path& file :
         {prefix / "lib" / "xrmock.json", prefix / "share" / "openxr" / "1" / "xrmock.json"})
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

records::AttemptInfo attemptInfo(const RunOptions& options, const AttemptFacts& facts,
                                 const records::RecordHeader& header, double gain,
                                 const std::optional<Registration>& registration) {
    records::AttemptInfo info;
    info.trainee = options.trainee;
    info.device = facts.device;
    info.patient = facts.patient_name;
    info.scenario = facts.scenario;
    info.difficulty = options.difficulty;
    info.program_version = STYLET_VERSION;
    info.patient_digest = header.package_digest;
    info.seed = facts.seed;
    info.dt_s = facts.dt_s;
    info.device_gain = gain;
    if (registration) info.registration_rms_m = registration->fre_m;
    return info;
}

bool isLive(const RunOptions& options) {
    return options.device != kScripted && options.device != kReplayDevice;
}

// Checks that the options of the command line fit together, before anything is created.
void checkHand(const RunOptions& options) {
    const auto refuse = [&](const char* option, const std::string& reason) {
        throw DataError(options.device, option, reason);
    };
    if (isLive(options) && options.fast) refuse("--fast", "a hand on a device moves in real time");
    if (!isLive(options) && options.seconds) refuse("--seconds", "only a hand on a device needs an end");
    if (options.device == kReplayDevice && options.trace.empty())
        refuse("--trace", "missing: the hand's CSV file");
    if (options.device != kReplayDevice && !options.trace.empty())
        refuse("--trace", "only for --device replay");
    if (options.device == kControllers) return;
    if (options.device == kMouse) {
        if (options.mirror == false) refuse("--no-mirror", "its hand is in the window");
        if (options.headless) refuse("--headless", "its hand is in a window");
        return;
    }
    if (isLive(options)) haptics::makeDriver(options.device, options.device_options, monotonicClock());
}

// The scripted attempt, or the same attempt with the input of a trace. The scenario's commands stay, up to
// the end of the trace.
Attempt withHand(const RunOptions& options, Attempt attempt, const Retry* retry, const MakeTouch& touch) {
    if (options.device == kReplayDevice) {
        attempt.hand.samples = haptics::loadTrace(options.trace).samples;
        const std::int64_t end_ns = attempt.hand.samples.back().t_ns;
        std::erase_if(attempt.hand.commands,
                      [end_ns](const haptics::TraceCommand& said) { return said.t_ns > end_ns; });
    }
    if (retry) beginAs(attempt, *retry, touch);
    return attempt;
}

// Opens the user's device and waits until it is ready.
std::unique_ptr<LiveDevice> readyDevice(const RunOptions& options, const haptics::Clock& clock) {
    catchInterrupts();
    auto live = std::make_unique<LiveDevice>(options.device, options.device_options, clock);
    if (!live->waitUntilReady(interrupted))
        throw DataError(options.device, "device", "given up before it was ready");
    return live;
}

// Live input of an attempt: ports, device, and the pose in which a tool is held if the device senses no
// orientation.
struct Live {
    std::shared_ptr<ControllerPort> port;  // of a controller; outlives the device
    std::shared_ptr<WindowPort> window = std::make_shared<WindowPort>();  // also outlives the device
    std::unique_ptr<LiveDevice> device;
    haptics::HapticDevice* aimed = nullptr;    // the device as the loop uses it
    std::optional<Registration> registration;  // pose of `device` in the headset's room
    std::optional<TippedDevice> tipped;        // wraps `aimed`: tip as found by the registration
    std::optional<PlacedDevice> placed;        // wraps `aimed`: moved to the recorded device's pose
    Quat device_from_needle{};
    haptics::GuideSettings guide;

    // Pose of `tool` in the device's axes, relative to a needle's tip.
    Pose held(haptics::Tool tool) const { return heldLike({device_from_needle, {}}, tool, guide); }
};

// Makes the attempt begin with the recorded ticks, and moves the device to the pose of the recorded one.
// Only for devices without force output; liveAttempt() handles the others.
void resume(Live& live, Attempt& attempt, const Retry* retry) {
    if (!retry) return;
    const Pose own = attempt.simulation.patient_from_device;
    beginAs(attempt, *retry);
    live.placed.emplace(*live.aimed, attempt.simulation.patient_from_device.inverse() * own);
    live.aimed = &*live.placed;
}

ControllerSide sideOf(const RunOptions& options) {
    return options.hand == "left" ? ControllerSide::left : ControllerSide::right;
}

// Controllers are tracked in the room that is drawn, so they need no registration. They are available only
// while the attempt runs, because only its pictures have an OpenXR session.
Attempt controllerAttempt(const RunOptions& options, Live& live, const patient::Patient& patient,
                          const Scenario& scenario, const patient::PlannedPath& path,
                          const haptics::Clock& clock, const Retry* retry, const MakeTouch& touch) {
    catchInterrupts();
    live.port = std::make_shared<ControllerPort>();
    live.device = std::make_unique<LiveDevice>(
        kControllers, std::make_unique<ControllerDriver>(*live.port, sideOf(options), clock), clock);
    Attempt attempt = makeLiveAttempt(patient, scenario, path, options.seed, touch(patient),
                                      controllerProfile(), {}, options.rate_hz);
    attempt.simulation.patient_from_device = stageFromPatient(patient, path).inverse();
    live.aimed = &live.device->bare();
    resume(live, attempt, retry);
    return attempt;
}

// The device frame of the mouse is the patient frame.
Attempt mouseAttempt(const RunOptions& options, Live& live, const patient::Patient& patient,
                     const Scenario& scenario, const patient::PlannedPath& path, const haptics::Clock& clock,
                     const Retry* retry, const MakeTouch& touch) {
    catchInterrupts();
    live.window->giveHand();
    live.window->tell(retry ? retry->left.tool : scenario.tool, 0.0);
    Attempt attempt = makeLiveAttempt(patient, scenario, path, options.seed, touch(patient), mouseProfile(),
                                      {}, options.rate_hz);
    attempt.simulation.patient_from_device = {};
    const haptics::GuideSettings& guide = attempt.simulation.tools.guide;
    const Pose start = retry && retry->left.tick > 0
                           ? retry->left.patient_from_tool * heldLike({}, retry->left.tool, guide).inverse()
                           : mouseStart(path);
    live.device = std::make_unique<LiveDevice>(
        kMouse, std::make_unique<MouseDriver>(*live.window, start, guide, clock), clock);
    live.aimed = &live.device->bare();
    resume(live, attempt, retry);
    return attempt;
}

Attempt liveAttempt(const RunOptions& options, Live& live, const patient::Patient& patient,
                    const Scenario& scenario, const patient::PlannedPath& path, const haptics::Clock& clock,
                    const Retry* retry, const MakeTouch& make_touch) {
    live.window->giveWords();
    if (options.device == kControllers)
        return controllerAttempt(options, live, patient, scenario, path, clock, retry, make_touch);
    if (options.device == kMouse)
        return mouseAttempt(options, live, patient, scenario, path, clock, retry, make_touch);
    haptics::TouchMap touch = make_touch(patient);  // first, because a device that is ready may be moved
    live.device = readyDevice(options, clock);
    live.registration = newestRegistration(dataFolder() / "registrations", options.device,
                                           std::string(live.device->profile().name));
    Attempt attempt =
        makeLiveAttempt(patient, scenario, path, options.seed, std::move(touch), live.device->profile(),
                        live.device->grip(), options.rate_hz, live.registration);
    haptics::SimulationSettings& settings = attempt.simulation;
    if (retry) settings.patient_from_device = retry->record.header.settings.patient_from_device;
    const Pose needle = needlePose(path.entry_m, glm::normalize(path.target_m - path.entry_m));
    live.device_from_needle = settings.patient_from_device.inverse().rotation * needle.rotation;
    live.guide = settings.tools.guide;
    live.aimed = &live.device->aimed(live.held(retry ? retry->left.tool : scenario.tool));
    if (live.registration && live.device->profile().senses_rotation) {
        live.tipped.emplace(*live.aimed, live.registration->stylus_from_tip_m);
        live.aimed = &*live.tipped;
    }
    settings.profile = live.aimed->profile();
    if (retry && !sameNumbers(settings.profile, retry->record.header.settings.profile))
        throw DataError(options.device, "--from",
                        "the attempt was made with another device, whose limits are part of it: go on with "
                        "that one, with the mouse or with controllers");
    if (retry) beginAs(attempt, *retry);
    return attempt;
}

training::Difficulty difficultyOf(const RunOptions& options) {
    if (options.difficulty.empty()) return training::Difficulty::practice;
    if (const auto difficulty = training::difficultyNamed(options.difficulty)) return *difficulty;
    throw DataError(options.difficulty, "--difficulty", "neither guided, nor practice, nor exam");
}

// Sounds for the trainee, and vibration of a controller. Session thread.
class Hearing {
  public:
    Hearing(const RunOptions& options, const SoundPlaces& places, double tick_s, ControllerPort* port,
            const std::shared_ptr<const Ears>& ears)
        : cues_(places, difficultyOf(options), tick_s), port_(port) {
        if (!options.fast && options.sound.value_or(!options.headless))
            sounds_.emplace(places.stage_from_operator, ears, Speaker::device, sayOnStderr);
    }
    void take(const Seen& seen) {
        const Heard& heard = cues_.take(seen);
        if (sounds_) sounds_->hear(heard);
        if (port_)
            if (const auto pulse = pulseOf(heard)) port_->vibrate(*pulse);
    }

  private:
    Cues cues_;
    ControllerPort* port_;
    std::optional<Sounds> sounds_;
};

LoopTotals runLive(const RunOptions& options, const Live& live, const Attempt& attempt, Session& session,
                   std::optional<Pictures> pictures, const haptics::Clock& clock,
                   const std::function<void(const Seen&)>& heard) {
    const UserButtons buttons = live.device->buttons();
    sayOnStderr("the hand is yours, with the " +
                std::string(haptics::kToolNames[std::size_t(attempt.simulation.tools.first)]) +
                "; \"help\" and Enter list what can be said; " + live.device->describeButtons() +
                (options.seconds ? "" : "; end with Ctrl-C"));
    const LiveHand hand{*live.aimed,
                        [&](double elapsed_s) {
                            live.device->tellNews();
                            return interrupted() || elapsed_s >= options.seconds.value_or(elapsed_s + 1.0);
                        },
                        [&] { return live.device->typed(); },
                        [&](haptics::Tool tool) { live.device->hold(live.held(tool)); },
                        buttons,
                        live.device->rearmAct(),
                        [&live, vibrations = Vibrations()](const haptics::TickOutput& newest) mutable {
                            live.window->tell(newest.tool, glm::length(newest.tool_force.force_n));
                            if (!live.port) return;
                            if (const auto felt = vibrations.take(newest)) live.port->vibrate(*felt);
                        }};
    session.setRearmButton(buttons.rearm);
    const LoopTotals totals = runRealTime(
        attempt, session, std::move(pictures), clock, &hand, heard, [&live] { return live.window->typed(); },
        options.frame_patience_s);
    // If the frames hang in the runtime, a controller's thread may hang there too. It has no force to end.
    if (!totals.frames_stuck || !live.port) live.device->stop();
    return totals;
}

// Description for the user.
std::string whereOf(const Retry& retry) {
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.1f s",
                  double(retry.bookmark.tick) * retry.record.header.settings.dt_s);
    return retry.folder.string() + " until bookmark " + std::to_string(retry.number) +
           (retry.bookmark.text.empty() ? "" : " (" + retry.bookmark.text + ")") + " at " + seconds;
}

void printBookmarks(const std::vector<records::Bookmark>& marks, const std::string& attempt,
                    const std::string& scenario) {
    if (marks.empty()) return;
    const std::string own = scenario.ends_with(".toml") ? " --scenario " + scenario : "";
    std::printf("  %zu bookmark%s; from there again: stylet run --from %s@%zu%s\n", marks.size(),
                marks.size() == 1 ? "" : "s", attempt.c_str(), marks.size(), own.c_str());
}

// The record contains only the scenario's name.
std::string scenarioOf(const Retry& retry) {
    const std::string& name = retry.record.info.scenario;
    if (std::filesystem::exists(assetsFolder() / "scenarios" / (name + ".toml"))) return name;
    throw DataError(retry.folder, "scenario \"" + name + "\"",
                    "is a file of your own: name it with --scenario");
}

}  // namespace

std::optional<Pictures> picturesFor(const Attempt& attempt, const patient::PlannedPath& path,
                                    const RunOptions& options, const std::string& rearm_act,
                                    const std::optional<Registration>& registration,
                                    std::shared_ptr<ControllerPort> controllers, std::shared_ptr<Ears> ears,
                                    std::shared_ptr<WindowPort> window) {
    if (options.fps.value_or(options.fast ? 0.0 : 1.0) <= 0.0) return std::nullopt;
    if (options.headless && environment(kRuntimeVariable).empty()) {
        const std::filesystem::path mock = bundledRuntime();
        if (!mock.empty()) setEnvironment(kRuntimeVariable, mock.string());
    }
    PictureSettings settings;
    settings.assets = assetsFolder();
    settings.pipeline_cache = cacheFolder() / "pipelines.bin";
    settings.capture_folder = options.out;
    settings.validation = options.validation;
    settings.virtual_clock = options.fast;
    settings.closed_look = options.look == "closed";
    settings.budget_ms = options.budget_ms;
    settings.count = options.stats;
    settings.touch = attempt.touchMap();
    settings.rearm_act = rearm_act;
    settings.seated = options.seated;
    settings.controllers = std::move(controllers);
    settings.controller_side = sideOf(options);
    settings.ears = std::move(ears);
    settings.window = std::move(window);
    settings.difficulty = difficultyOf(options);
    settings.passthrough = options.passthrough;
    settings.foveation = options.foveation;
    if (registration) settings.colocation = {*registration, attempt.simulation.patient_from_device};
    settings.tick_s = attempt.simulation.dt_s;
    settings.guide = attempt.simulation.tools.guide;
    settings.mirror =
        options.mirror.value_or(!options.headless && !options.fast && !environment(kDisplayVariable).empty());
    std::string why_not;
    if (settings.window && settings.window->hasHand()) {
        auto pictures = openDesktop(attempt.patient, path, settings, why_not);
        if (!pictures)
            throw DataError(kMouse, "device", "its hand is in a window, and there is none: " + why_not);
        return pictures;
    }
    auto pictures = openPictures(attempt.patient, path, settings, why_not);
    if (!pictures && settings.mirror && !settings.controllers) {
        std::string no_window;
        pictures = openDesktop(attempt.patient, path, settings, no_window);
        if (pictures)
            sayOnStderr("no headset: " + why_not + "; a window takes its place");
        else
            why_not += "; nor a window: " + no_window;
    }
    if (!pictures)
        std::fprintf(stderr, "stylet: no pictures: %s; continuing without pictures\n", why_not.c_str());
    return pictures;
}

namespace {

// A finished attempt.
struct Ended {
    RunOptions options;            // options of the attempt
    std::filesystem::path folder;  // folder of its results
    bool has_bookmark = false;
    std::optional<NextAttempt> next;  // requested by the instructor
};

Ended runOne(const RunOptions& asked, SteadyTime begun) {
    RunOptions options = asked;
    Start start;
    start.begun = begun;
    checkHand(options);
    difficultyOf(options);
    // Suppresses the messages of the sound library. Set here, before there are threads.
    if (environment(kSoundLogVariable).empty()) setEnvironment(kSoundLogVariable, "0");
    std::optional<Keeper> keeper;
    if (options.trainee.empty()) {
        needFolder(options.out, "--out");
    } else {
        records::checkTrainee(options.trainee);
        keeper.emplace(options.records.empty() ? dataFolder() / "records" : options.records, options.database,
                       sayOnStderr);
        if (options.difficulty.empty() && keeper->isNew(options.trainee)) {
            options.difficulty = training::nameOf(training::Difficulty::guided);
            sayOnStderr("the first run of " + options.trainee + " is guided; --difficulty asks for another");
        }
    }
    if (options.difficulty.empty()) options.difficulty = training::nameOf(training::Difficulty::practice);
    std::optional<Retry> retry;
    if (!options.from.empty()) {
        retry = openRetry(options.from, options.records.empty() ? dataFolder() / "records" : options.records);
        const records::RecordInfo& recorded = retry->record.info;
        if (options.patient.empty()) options.patient = recorded.patient_folder;
        if (options.scenario.empty()) options.scenario = scenarioOf(*retry);
        options.seed = recorded.seed;
        options.rate_hz = 1.0 / retry->record.header.settings.dt_s;
    }
    const Scenario scenario =
        loadScenario(scenarioFile(options.scenario.empty() ? "demo" : options.scenario));
    start.asked = std::chrono::steady_clock::now();
    const OpenedPatient opened = openPatient(
        {options.patient, options.seed, options.spacing_mm / 1000.0, cacheFolder(), assetsFolder()});
    start.made = opened.made;
    const patient::Patient patient(opened.package);
    const std::optional<OtherSegmentation> other = otherSegmentation(patient, options.full);
    const patient::PlannedPath path =
        retry ? retry->record.info.path : referencePath(patient, opened.folder, options.path, &start.made);
    if (retry) checkRetry(*retry, patient);
    const std::uint64_t patient_digest = patient::digest(opened.package);
    start.patient = std::chrono::steady_clock::now();
    const MakeTouch touch = [&](const patient::Patient& on) {
        return keptTouchMap(on, patient_digest, cacheFolder() / "derived", &start.made);
    };
    const haptics::Clock clock = monotonicClock();
    Live live;
    const Attempt attempt =
        isLive(options)
            ? liveAttempt(options, live, patient, scenario, path, clock, retry ? &*retry : nullptr, touch)
            : withHand(options, makeAttempt(patient, scenario, path, options.seed, options.rate_hz, touch),
                       retry ? &*retry : nullptr, touch);
    AttemptFacts facts{opened.package.name,
                       opened.folder,
                       scenario.name,
                       options.seed,
                       options.fast ? "virtual" : "real time",
                       path,
                       attempt.simulation.dt_s,
                       options.device,
                       haptics::firmwareDigest(options.device_options)};

    const auto ears = std::make_shared<Ears>();
    const records::RecordHeader header{patient_digest, attempt.simulation};
    const double gain = haptics::outputGain(attempt.simulation.profile, attempt.simulation.output);
    start.hand = std::chrono::steady_clock::now();
    if (keeper) options.out = keeper->begin(attemptInfo(options, facts, header, gain, live.registration));
    auto pictures =
        picturesFor(attempt, path, options, live.device && !live.port ? live.device->rearmAct() : "",
                    live.registration, live.port, ears, live.window);
    start.pictures = std::chrono::steady_clock::now();
    facts.start = start;
    if (live.port && !pictures)
        throw DataError(kControllers, "device", "there is no headset to hold them with");
    records::RecordInfo info = recordInfo(facts, scenario, gain);
    if (retry) {
        const std::vector<records::Bookmark>& marks = retry->record.info.bookmarks;
        info.bookmarks.assign(marks.begin(), marks.begin() + std::ptrdiff_t(retry->number));
    }
    records::RecordWriter record(options.out / "record", header, info);
    std::optional<ForceTruth> truth;
    Session session(patient, path, scenario.moments, scenario.approach_distance_m, &record,
                    attempt.simulation.dt_s);
    session.setDifficulty(difficultyOf(options));
    if (retry) {
        const std::string where = whereOf(*retry);
        session.note("retry", where);
        sayOnStderr("begins as " + where +
                    (live.device ? "; bring the tool to where it was left, and the attempt goes on" : "") +
                    (live.device && live.device->profile().force_axes > 0
                         ? "; then its force comes back: " + live.device->rearmAct()
                         : ""));
    }
    if (other) session.compareWith(truth.emplace(*other, attempt.simulation.tools.needle));
    Hearing hearing(options, soundPlaces(patient, path), attempt.simulation.dt_s, live.port.get(), ears);
    // True if the user feels forces from a device, or holds controllers and therefore wears a headset.
    const bool strains = live.device && (live.port || live.device->profile().force_axes > 0);
    RestWatch rest(strains && keeper ? keeper->sinceRest_s(options.trainee) : 0.0);
    const auto heard = [&](const Seen& seen) {
        hearing.take(seen);
        if (!strains) return;
        const bool inside = seen.tick.phase != haptics::Phase::outside;
        if (rest.pass(double(clock.now_ns(clock.context)) * 1e-9, !seen.held && !seen.paused, inside)) {
            sayOnStderr(restAdvice(rest.atIt_s()));
            session.note("rest", restAdvice(rest.atIt_s()));
        }
        session.showRest(rest.shown());
    };
    if (keeper) {
        session.setWatcher(
            [&](const haptics::TickOutput& now, const SessionLog& log) { keeper->take(now, log); });
        session.setNoteWatcher([&](const SessionLog& log) { keeper->storeEvents(log); });
    }
    const LoopTotals totals =
        live.device ? runLive(options, live, attempt, session, std::move(pictures), clock, heard)
        : options.fast
            ? runFast(attempt, session, std::move(pictures), options.fps.value_or(0.0), workClock())
            : runRealTime(
                  attempt, session, std::move(pictures), clock, nullptr, heard,
                  [&live] { return live.window->typed(); }, options.frame_patience_s);
    record.finish();
    if (record.lost())
        std::fprintf(stderr, "stylet: the record ends at tick %llu: the next was lost to a full ring\n",
                     static_cast<unsigned long long>(record.lost()->first - 1));
    writeResults(patient, facts, session.log(), totals, options.out);
    if (keeper)
        std::printf("stored as attempt %s of %s\n", keeper->finish(session.log()).c_str(),
                    options.trainee.c_str());
    printResults(facts, session.log(), totals, options.out, options.stats);
    printBookmarks(record.bookmarks(), keeper ? options.out.filename().string() : options.out.string(),
                   options.scenario);
    if (keeper && keeper->send() > 0)
        sayOnStderr(
            "the training centre does not have all yet; the next run, or \"stylet records sync\", sends it");
    if (totals.frames_stuck) {
        sayOnStderr(
            "the OpenXR runtime does not let go of a frame; all is stored, and the program ends without it");
        std::fflush(nullptr);
        std::_Exit(0);
    }
    if (session.difficulty()) options.difficulty = training::nameOf(*session.difficulty());
    return {options, options.out, !record.bookmarks().empty(), totals.next};
}

// Options of the next attempt. An invalid request is reported and ignored: a typing error of the instructor
// must not end the program.
RunOptions following(const Ended& last, const RunOptions& asked, int number) {
    RunOptions next = last.options;
    next.from.clear();
    next.out = asked.out;
    if (!asked.out.empty()) next.out += "-" + std::to_string(number);
    if (last.next->from_bookmark) {
        if (!last.has_bookmark) sayOnStderr("instructor: no bookmark was set: it begins from its start");
        if (last.has_bookmark) next.from = last.folder.string();
        return next;
    }
    if (last.next->difficulty)
        next.difficulty = training::kDifficultyNames[std::size_t(*last.next->difficulty)];
    const auto tried = [](const auto& change) {
        try {
            change();
        } catch (const std::exception& e) {
            sayOnStderr("instructor: " + std::string(e.what()) + "; as before instead");
        }
    };
    if (last.next->scenario)
        tried([&] {
            loadScenario(scenarioFile(*last.next->scenario));
            next.scenario = *last.next->scenario;
        });
    if (last.next->patient)
        tried([&] {
            const std::filesystem::path folder = *last.next->patient;
            if (!std::filesystem::exists(folder / "patient.toml"))
                throw DataError(folder, "patient.toml", "is not there");
            next.patient = folder, next.full.clear();
        });
    if (last.next->seed) next.seed = *last.next->seed;
    if (last.next->seed && !last.next->patient) next.patient.clear(), next.full.clear();
    if (last.next->seed || last.next->patient) next.path.clear();  // the path belongs to the previous patient
    return next;
}

}  // namespace

int run(const RunOptions& asked) {
    Ended last = runOne(asked, asked.begun);
    for (int number = 2; last.next && !interrupted(); ++number) {
        const RunOptions next = following(last, asked, number);
        sayOnStderr("the next attempt");
        const SteadyTime begun = std::chrono::steady_clock::now();
        try {
            last = runOne(next, begun);
        } catch (const DataError& e) {
            sayOnStderr("instructor: " + std::string(e.what()) + "; as before instead");
            RunOptions before = last.options;
            before.from.clear(), before.out = next.out;
            last = runOne(before, begun);
        }
    }
    return 0;
}

}  // namespace stylet::trainer
