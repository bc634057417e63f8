#include "app/trainer/program/run.h"

#include <fmt/core.h>
#include <cstdlib>
#include <glm/geometric.hpp>

#include "app/installation.h"
#include "app/trainer/attempt/demonstration.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/hands/snap.h"
#include "app/trainer/loop/force_feed.h"
#include "app/trainer/loop/loops.h"
#include "app/trainer/program/live_input.h"
#include "app/trainer/program/results.h"
#include "app/trainer/program/task.h"
#include "app/trainer/session/attempt_writer.h"
#include "app/trainer/session/rest.h"
#include "app/trainer/session/session_recorder.h"
#include "app/trainer/sound/sounds.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/folder_linux.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

namespace {

constexpr const char* kRuntimeVariable = "XR_RUNTIME_JSON";
constexpr const char* kDisplayVariable = "DISPLAY";
constexpr const char* kSoundLogVariable = "ALSOFT_LOGLEVEL";

// Manifest of the bundled mock runtime, in this program's build tree or installation.
std::filesystem::path bundledRuntime() {
    const std::filesystem::path prefix = programFolder().parent_path();
    for (const char* file : {"lib/xrmock.json", "share/openxr/1/xrmock.json"})
        if (std::filesystem::exists(prefix / file)) return prefix / file;
    return {};
}

records::RecordInfo recordInfo(const AttemptConfig& config, const AttemptFacts& facts,
                               const Scenario& scenario, double gain) {
    records::RecordInfo info;
    info.device = facts.device;
    info.firmware_sha256 = facts.firmware_sha256;
    info.clock = facts.clock;
    info.difficulty = training::difficultyName(config.difficulty);
    info.program_version = STYLET_VERSION;
    info.patient_folder = facts.patient_folder;
    info.patient_name = facts.patient_name;
    info.patient_check = facts.patient_check;
    info.scenario = facts.scenario;
    info.course = enumName(training::kCourseNames, scenario.course);
    if (scenario.patient_case) info.patient_case = scenario.patient_case->toml;
    info.capture_points = scenario.moments;
    info.approach_distance_m = scenario.approach_distance_m;
    info.seed = facts.seed;
    info.gain = gain;
    info.path = facts.path;
    return info;
}

records::AttemptInfo attemptInfo(const AttemptConfig& config, const AttemptFacts& facts,
                                 const records::RecordHeader& header, double gain,
                                 const std::optional<Registration>& registration) {
    records::AttemptInfo info;
    info.trainee = config.trainee;
    info.device = facts.device;
    info.patient = facts.patient_name;
    info.scenario = facts.scenario;
    info.difficulty = training::difficultyName(config.difficulty);
    info.program_version = STYLET_VERSION;
    info.patient_digest = header.package_digest;
    info.seed = facts.seed;
    info.dt_s = facts.dt_s;
    info.device_gain = gain;
    if (registration) info.registration_rms_m = registration->fre_m;
    return info;
}

// Checks that the options of the command line are compatible with each other, before anything is created.
void checkHand(const RunOptions& options) {
    const AttemptConfig& config = options.config;
    checkDeviceName(config.device, {kScriptedDevice, kReplayDevice, kControllers, kMouse});
    if (isLive(config) && config.fast)
        throw UsageError("--fast: the device " + config.device + " runs in real time; remove --fast");
    if (!isLive(config) && config.seconds)
        throw UsageError("--seconds: only for a device; a scripted or replayed attempt ends by itself");
    checkTraceOption(config.device, config.trace);
    if (config.device == kControllers) return;
    if (config.device == kMouse) {
        if (options.mirror == false || config.headless)
            throw UsageError("--device mouse needs the window; remove --no-mirror and --headless");
        return;
    }
    if (isLive(config)) haptics::makeDriver(config.device, config.device_options, monotonicClock());
}

// Returns the scripted attempt. With the replay device, its input is the trace, and the scenario's commands
// are kept up to the end of the trace. With `retry`, the attempt begins with the recorded ticks.
Attempt withHand(const AttemptConfig& config, Attempt attempt, const Retry* retry, const MakeTouch& touch) {
    if (config.device == kReplayDevice) {
        attempt.hand.samples = haptics::loadTrace(config.trace).samples;
        const std::int64_t end_ns = attempt.hand.samples.back().t_ns;
        std::erase_if(attempt.hand.commands,
                      [end_ns](const haptics::TraceCommand& command) { return command.t_ns > end_ns; });
    }
    if (retry) startFromRecord(attempt, *retry, touch);
    return attempt;
}

training::Difficulty parseDifficulty(const std::string& name) {
    if (name.empty()) return training::Difficulty::practice;
    if (const auto difficulty = training::difficultyFromName(name)) return *difficulty;
    throw UsageError("--difficulty " + name + ": must be guided, practice or exam");
}

// Plays sounds for the trainee and lets a controller vibrate. Session thread.
class SoundOutput {
  public:
    SoundOutput(const AttemptConfig& config, const SoundPlaces& places, double tick_s, ControllerPort* port,
                const std::shared_ptr<const ListenerPose>& listener_pose)
        : cues_(places, config.difficulties, config.difficulty, tick_s), port_(port) {
        if (config.sound)
            sounds_.emplace(places.stage_from_operator, listener_pose, Speaker::device, printMessage);
    }
    void update(const FrameState& seen) {
        const SoundFrame& frame = cues_.update(seen);
        if (sounds_) sounds_->submit(frame);
        if (port_)
            if (const auto pulse = alertPulse(frame)) port_->vibrate(*pulse);
    }

  private:
    Cues cues_;
    ControllerPort* port_;
    std::optional<Sounds> sounds_;
};

// Describes the bookmark for the user.
std::string describeBookmark(const Retry& retry) {
    return fmt::format("{} until bookmark {}{} at {:.1f} s", retry.folder.string(), retry.number,
                       retry.bookmark.text.empty() ? "" : " (" + retry.bookmark.text + ")",
                       double(retry.bookmark.tick) * retry.record.header.settings.dt_s);
}

void printBookmarks(const std::vector<records::Bookmark>& marks, const std::string& attempt,
                    const std::string& scenario) {
    if (marks.empty()) return;
    const std::string own = scenario.ends_with(".toml") ? " --scenario " + scenario : "";
    printResult("  {} bookmark{}; restart there: stylet run --from {}@{}{}\n", marks.size(),
                marks.size() == 1 ? "" : "s", attempt, marks.size(), own);
}

// The record contains only the name of the scenario. Finds its file.
std::string findScenario(const Retry& retry) {
    const std::string& name = retry.record.info.scenario;
    if (std::filesystem::exists(assetsFolder() / "scenarios" / (name + ".toml"))) return name;
    throw DataError(retry.folder, "scenario \"" + name + "\"",
                    "is not an installed scenario: name its file with --scenario");
}

}  // namespace

std::unique_ptr<Display> picturesFor(const Attempt& attempt, const patient::PlannedPath& path,
                                     PictureSettings settings) {
    if (settings.config.fps <= 0.0) return nullptr;
    if (settings.config.headless && environment(kRuntimeVariable).empty()) {
        const std::filesystem::path mock = bundledRuntime();
        if (!mock.empty()) setEnvironment(kRuntimeVariable, mock.string());
    }
    settings.assets = assetsFolder();
    settings.pipeline_cache = cacheFolder() / "pipelines.bin";
    settings.press = {attempt.touchMap(), attempt.simulation.tools, attempt.simulation.dt_s};
    std::string why_not;
    if (settings.window && settings.window->hasToolInput()) {
        auto pictures = openDesktop(attempt.patient, path, settings, why_not);
        if (!pictures) throw EnvironmentError("--device mouse needs a window, and there is none: " + why_not);
        return pictures;
    }
    auto pictures = openPictures(attempt.patient, path, settings, why_not);
    if (!pictures && settings.config.mirror && !settings.controllers) {
        std::string no_window;
        pictures = openDesktop(attempt.patient, path, settings, no_window);
        if (pictures)
            printMessage("no headset: " + why_not + "; using a window instead");
        else
            why_not += "; no window either: " + no_window;
    }
    // Controllers cannot continue without a headset: openOutputs() then refuses the run.
    if (!pictures)
        printMessage("no pictures: " + why_not +
                     (settings.controllers ? "" : "; continuing without pictures"));
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

// An attempt from its options to its results. Members refer only to members declared before them.
struct AttemptRun {
    std::string start_refused;  // see FrameState
    RunOptions options;         // `config` is complete once openStore() has returned
    Start start;
    const haptics::Clock clock = monotonicClock();
    std::optional<AttemptWriter> attempt_writer;  // only if a trainee is named
    std::optional<Retry> retry;
    std::optional<Task> task;
    Live live;
    std::optional<Attempt> attempt;
    AttemptFacts facts;
    const std::shared_ptr<ListenerPose> listener_pose = std::make_shared<ListenerPose>();
    std::unique_ptr<Display> pictures;
    std::optional<records::RecordWriter> record;
    std::optional<SessionRecorder> recorder;
    std::optional<ForceComparison> truth;
    std::optional<Session> session;
    std::optional<SoundOutput> sound_output;
    std::optional<ExpertBeside> expert;  // with live input
};

// An exam shows what the trainee can do from the beginning to the end.
void checkExam(const RunOptions& options) {
    const AttemptConfig& config = options.config;
    if (config.difficulty != training::Difficulty::exam) return;
    if (!options.from.empty())
        throw UsageError("--from: an exam begins at the beginning; use guided or practice");
    if (config.accept_implausible)
        throw UsageError("--accept-implausible: an exam needs a patient that the check accepted");
    if (!config.trainee.empty() && !isLive(config))
        throw UsageError("--device " + config.device + ": an exam of a trainee needs the trainee's own hand");
}

// Opens the store and completes the configuration.
void openStore(AttemptRun& run) {
    RunOptions& options = run.options;
    AttemptConfig& config = options.config;
    checkHand(options);
    parseDifficulty(options.difficulty);
    // Suppresses the messages of the sound library. Set here, before there are threads.
    if (environment(kSoundLogVariable).empty()) setEnvironment(kSoundLogVariable, "0");
    const auto store_folder = [&options] {
        return options.records.empty() ? dataFolder() / "records" : options.records;
    };
    if (config.trainee.empty()) {
        requireFolder(config.folder, "--out");
    } else {
        records::checkTrainee(config.trainee);
        if (options.records.empty() && isDataTemporary())
            printMessage(store_folder().string() +
                         " is temporary: set HOME or XDG_DATA_HOME, or the attempt will be lost");
        run.attempt_writer.emplace(store_folder(), options.database, printMessage);
        if (options.difficulty.empty() && run.attempt_writer->needsGuidance(config.trainee)) {
            options.difficulty = training::difficultyName(training::Difficulty::guided);
            printMessage(
                config.trainee +
                " has completed no guided attempt yet, so this one is guided; use --difficulty for another");
        }
    }
    config.difficulty = parseDifficulty(options.difficulty);
    config.difficulties = training::loadDifficulties(assetsFolder() / "difficulty.toml");
    checkExam(options);
    config.closed_look = options.look == "closed";
    config.look_file = assetFile("look", options.look);
    config.fps = options.fps.value_or(config.fast ? 0.0 : 1.0);
    config.mirror =
        options.mirror.value_or(!config.headless && !config.fast && !environment(kDisplayVariable).empty());
    config.sound = !config.fast && options.sound.value_or(!config.headless);
    if (options.from.empty()) return;
    run.retry = openRetry(options.from, store_folder());
    const records::RecordInfo& recorded = run.retry->record.info;
    if (config.patient.empty()) config.patient = recorded.patient_folder;
    if (config.scenario.empty())
        config.scenario = findScenario(*run.retry);
    else if (loadScenario(scenarioFile(config.scenario)).name != recorded.scenario)
        throw UsageError("--scenario " + config.scenario + ": --from restarts the scenario \"" +
                         recorded.scenario + "\"; remove --scenario");
    config.seed = recorded.seed;
    config.rate_hz = 1.0 / run.retry->record.header.settings.dt_s;
    config.instruments = run.retry->record.header.instruments;
    config.tools = run.retry->record.header.settings.tools;
}

// Opens the patient and the input. Waits until a device is ready.
void openInput(AttemptRun& run) {
    AttemptConfig& config = run.options.config;
    Retry* const retry = run.retry ? &*run.retry : nullptr;
    const Task& task = run.task.emplace(config, retry, run.start);
    if (!retry) loadInstruments(config, task.scenario);
    if (isLive(config))
        run.attempt.emplace(liveAttempt(config, task, run.live, run.clock, retry));
    else
        run.attempt.emplace(withHand(
            config,
            makeAttempt(task.patient, task.scenario, task.path, config.seed, config.rate_hz, task.make_touch),
            retry, task.make_touch));
    if (!retry) equip(*run.attempt, config.tools);
    run.facts = {task.opened.package.name,
                 task.opened.folder,
                 task.scenario.name,
                 config.seed,
                 config.fast ? "virtual" : "real time",
                 task.path,
                 run.attempt->simulation.dt_s,
                 config.device,
                 haptics::firmwareDigest(config.device_options)};
    run.facts.patient_check = task.opened.check;
    run.start.hand = std::chrono::steady_clock::now();
}

std::unique_ptr<Display> openAttemptDisplay(const AttemptRun& run) {
    const Live& live = run.live;
    PictureSettings settings;
    settings.config = run.options.config;
    settings.field = run.task->field;
    if (live.device) settings.rearm_act = live.device->rearmAct();
    // Without force there is no place at which the user could feel the tool.
    if (live.registration && live.device->exertsForce())
        settings.colocation = {*live.registration, run.attempt->simulation.patient_from_device};
    settings.controllers = live.port;
    settings.window = live.window;
    settings.listener_pose = run.listener_pose;
    return picturesFor(*run.attempt, run.task->path, std::move(settings));
}

// Begins the attempt in the store. Opens pictures, record and sounds.
void openOutputs(AttemptRun& run) {
    AttemptConfig& config = run.options.config;
    const Task& task = *run.task;
    const Attempt& attempt = *run.attempt;
    const Live& live = run.live;
    const records::RecordHeader header{task.patient_digest, attempt.simulation, config.instruments};
    const double gain = haptics::outputGain(attempt.simulation.profile, attempt.simulation.output);
    records::RecordInfo info = recordInfo(config, run.facts, task.scenario, gain);
    if (live.registration) info.registration_rms_m = live.registration->fre_m;
    if (run.attempt_writer) {
        const records::StoredAttempt begun =
            run.attempt_writer->begin(attemptInfo(config, run.facts, header, gain, live.registration));
        config.folder = begun.folder;
        info.id = begun.id, info.trainee = begun.info.trainee, info.started_utc = begun.started_utc;
    }
    run.pictures = openAttemptDisplay(run);
    run.start.pictures = std::chrono::steady_clock::now();
    run.facts.start = run.start;
    if (live.port && !run.pictures)
        throw EnvironmentError("--device controllers needs a headset, and none is available");
    if (run.retry) {
        const std::vector<records::Bookmark>& marks = run.retry->record.info.bookmarks;
        info.bookmarks.assign(marks.begin(), marks.begin() + std::ptrdiff_t(run.retry->number));
    }
    run.record.emplace(config.folder / "record", header, info);
    run.recorder.emplace(config.folder / "record",
                         records::SamplesHeader{task.patient_digest, attempt.simulation.dt_s}, *run.record);
    Session& session =
        run.session.emplace(task.patient, task.path, task.scenario.moments, task.scenario.approach_distance_m,
                            &*run.record, attempt.simulation.dt_s);
    session.setDifficulty(config.difficulty);
    session.setInstruments(config.instruments);
    session.setCourse(task.scenario.course);
    session.setCase(task.scenario.patient_case);
    session.setAccess(attempt.simulation.tools.access);
    session.setStartRefused(run.start_refused);
    if (run.retry) {
        const std::string where = describeBookmark(*run.retry);
        session.note("retry", where);
        printMessage("restarting " + where +
                     (live.device ? "; move the tool back to where it was left to resume the attempt" : "") +
                     (live.device && live.device->exertsForce()
                          ? "; then re-arm the force with " + live.device->rearmAct()
                          : ""));
    }
    if (task.other) session.compareWith(run.truth.emplace(*task.other, attempt.simulation.tools.needle));
    run.sound_output.emplace(config, soundPlaces(task.patient, task.field), attempt.simulation.dt_s,
                             live.port.get(), run.listener_pose);
}

const training::DifficultyRules& rulesNow(const AttemptRun& run) {
    const AttemptConfig& config = run.options.config;
    return config.difficulties[run.session->difficulty().value_or(config.difficulty)];
}

LoopTotals runLive(AttemptRun& run, RealTimeOptions options) {
    const Live& live = run.live;
    run.expert.emplace([&task = *run.task, &attempt = *run.attempt] {
        return Demonstration(task.patient, task.path, task.scenario.course,
                             [&attempt](const patient::Patient&) { return *attempt.touch; });
    });
    options.help = [&run](FrameState& seen) {
        run.expert->addTo(seen, rulesNow(run), run.attempt->simulation.dt_s);
    };
    const std::optional<double> seconds = run.options.config.seconds;
    const UserButtons buttons = live.device->buttons();
    printMessage(fmt::format("you control the {}; type \"help\" and press Enter for a list of commands; {}{}",
                             enumName(haptics::kToolNames, run.attempt->simulation.tools.first),
                             live.device->describeButtons(run.task->scenario.course),
                             seconds ? "" : "; press Ctrl-C to end"));
    LiveHand hand{*live.loop_device,
                  [&](double elapsed_s) {
                      live.device->reportStateChanges();
                      return interrupted() || elapsed_s >= seconds.value_or(elapsed_s + 1.0);
                  },
                  [&] { return live.device->typed(); },
                  [&](haptics::Tool tool) { live.device->setTool(live.toolPose(tool)); },
                  buttons,
                  live.device->rearmAct(),
                  [&live, vibrations = Vibrations()](const haptics::TickOutput& newest) mutable {
                      live.window->publish(newest.tool, glm::length(newest.tool_force.force_n));
                      if (!live.port) return;
                      live.port->setTouching(touchesPatient(newest));
                      if (const auto felt = vibrations.update(newest)) live.port->vibrate(*felt);
                  }};
    if (live.patient_from_driver)
        hand.snap = [&run](const haptics::TickOutput& now) {
            return snapToSkin(run.live, *run.attempt, rulesNow(run), now);
        };
    hand.expert = [&run] { return run.expert->toggle(rulesNow(run)); };
    run.session->setRearmButton(buttons.rearm);
    options.live = &hand;
    const LoopTotals totals =
        runRealTime(*run.attempt, *run.session, std::move(run.pictures), run.clock, options);
    // If the frames hang in the runtime, a controller's thread may hang there too. A controller renders no
    // force that would have to be stopped.
    if (!totals.frames_stuck || !live.port) live.device->stop();
    return totals;
}

// Instructor's commands from the window and, without a live device, from stdin. A live device reads stdin
// itself (LiveHand::typed).
std::function<std::string()> makeConsole(const AttemptRun& run) {
    const bool window = run.options.config.mirror;
    return [port = run.live.window, window, open = !run.live.device]() mutable {
        std::string text = port->typed();
        if (!open || (open = readTyped(text))) return text;
        // The end of stdin ends its last line. Without a window, nobody could resume a paused attempt.
        return text + (window ? "\n" : "\ngo on\n");
    };
}

// Runs the loops until the attempt ends.
LoopTotals play(AttemptRun& run) {
    const AttemptConfig& config = run.options.config;
    const Live& live = run.live;
    Session& session = *run.session;
    // True if the user feels forces from a device or uses controllers. A user with controllers wears a
    // headset.
    const bool strains = live.device && (live.port || live.device->exertsForce());
    RestWatch rest(strains && run.attempt_writer ? run.attempt_writer->sinceRest_s(config.trainee) : 0.0);
    const auto on_state = [&](const FrameState& seen) {
        run.sound_output->update(seen);
        if (!strains) return;
        const bool inside = seen.tick.phase != haptics::Phase::outside;
        if (rest.update(double(run.clock.now_ns(run.clock.context)) * 1e-9,
                        !seen.ticks_paused && !seen.paused_by_instructor, inside)) {
            printMessage(restAdvice(rest.worked_s()));
            session.note("rest", restAdvice(rest.worked_s()));
        }
        session.showRest(rest.shown());
    };
    session.setWatcher([&run](const haptics::TickOutput& now, const SessionLog& log) {
        run.recorder->update(now, log);
        if (run.attempt_writer) run.attempt_writer->keep();
    });
    session.setNoteWatcher([&run](const SessionLog& log) { run.recorder->writeEvents(log); });
    if (!live.device && config.fast)
        return runFast(*run.attempt, session, std::move(run.pictures), config.fps, workClock());
    const RealTimeOptions options{
        .on_state = on_state, .console = makeConsole(run), .frame_patience_s = config.frame_patience_s};
    if (live.device) return runLive(run, options);
    return runRealTime(*run.attempt, session, std::move(run.pictures), run.clock, options);
}

// Why an attempt that is stored enters no statistics; empty: it enters them.
std::string whyItDoesNotCount(const AttemptRun& run) {
    if (run.record->info().result->aborted) return ", aborted: it enters no statistics";
    return run.retry ? ", restarted: it enters no statistics" : "";
}

void printVerdict(const training::Progress& progress) {
    const std::vector<std::string_view> missing =
        training::missingParts(progress.course, progress.steps_done);
    printResult("  exam {}\n", training::passesExam(progress) ? "passed" : "failed");
    for (const std::string_view part : missing)
        printResult("    missing: {}\n", part);
}

// Writes the results and completes the attempt in the store. Exits the program if the runtime has not
// returned from a frame.
Ended store(AttemptRun& run, const LoopTotals& totals) {
    RunOptions& options = run.options;
    const AttemptConfig& config = options.config;
    const Session& session = *run.session;
    const training::Difficulty difficulty = session.easiestDifficulty();
    const bool exam = difficulty == training::Difficulty::exam;
    run.record->setDifficulty(std::string(training::difficultyName(difficulty)));
    run.recorder->finish(session.log(), makeResult(run.task->patient, session.log(), totals, exam));
    const records::RecordInfo& record = run.record->info();
    if (record.lost)
        printMessage(
            fmt::format("the record ends at tick {}: the ring buffer was full and the next tick was lost",
                        record.lost->first - 1));
    writeResults({run.task->patient, run.facts, record}, session.log(), totals, config.folder);
    if (run.attempt_writer)
        printResult("stored as attempt {} of {}{}\n", run.attempt_writer->finish(), config.trainee,
                    whyItDoesNotCount(run));
    printResults(run.facts, session.log(), totals, config.folder, config.stats);
    if (exam && record.result->aborted)
        printResult("  exam not begun: nothing was reached\n");
    else if (exam)
        printVerdict(session.log().progress);
    printBookmarks(record.bookmarks,
                   run.attempt_writer ? config.folder.filename().string() : config.folder.string(),
                   config.scenario);
    if (run.attempt_writer && run.attempt_writer->send() > 0)
        printMessage(
            "some attempts are not at the training centre yet; the next run or \"stylet records sync\" sends "
            "them");
    if (totals.frames_stuck) {
        printMessage(
            "the OpenXR runtime does not release a frame; all is stored, and the program ends without "
            "waiting for it");
        std::fflush(nullptr);
        std::_Exit(0);
    }
    if (session.difficulty()) options.difficulty = training::difficultyName(*session.difficulty());
    return {options, config.folder, !record.bookmarks.empty(), totals.next};
}

Ended runOne(const RunOptions& asked, SteadyTime begun, const std::string& start_refused = "") {
    AttemptRun run;
    run.start_refused = start_refused;
    run.options = asked;
    run.start.begun = begun;
    openStore(run);
    openInput(run);
    openOutputs(run);
    const LoopTotals totals = play(run);
    return store(run, totals);
}

// Options of the next attempt. An invalid request is added to `refused` and ignored, so that an instructor's
// typing error does not end the program.
RunOptions nextOptions(const Ended& last, const RunOptions& asked, int number, std::string& refused) {
    RunOptions next = last.options;
    next.from.clear();
    next.config.folder = asked.config.folder;
    if (!asked.config.folder.empty()) next.config.folder += "-" + std::to_string(number);
    if (last.next->from_bookmark) {
        if (last.has_bookmark)
            next.from = last.folder.string();
        else
            refused = "no bookmark was set; restarting from the beginning. ";
        return next;
    }
    if (last.next->difficulty) next.difficulty = training::difficultyName(*last.next->difficulty);
    const auto tried = [&refused](const auto& change) {
        try {
            change();
        } catch (const std::exception& e) {
            refused += std::string(e.what()) + "; keeping the earlier setting. ";
        }
    };
    if (last.next->scenario)
        tried([&] {
            loadScenario(scenarioFile(*last.next->scenario));
            next.config.scenario = *last.next->scenario;
        });
    if (last.next->patient)
        tried([&] {
            const std::filesystem::path folder = *last.next->patient;
            if (!std::filesystem::exists(folder / "patient.toml"))
                throw DataError(folder, "patient.toml", "not found: this is no patient package");
            next.config.patient = folder, next.config.full.clear();
            next.config.accept_implausible = false;  // said of the previous patient
        });
    if (last.next->seed) next.config.seed = *last.next->seed;
    if (last.next->seed && !last.next->patient) next.config.patient.clear(), next.config.full.clear();
    if (last.next->seed || last.next->patient)
        next.config.path.clear();  // the path belongs to the previous patient
    return next;
}

// Options that the last attempt began with, for the folder of the refused one.
RunOptions optionsBefore(const Ended& last, const RunOptions& refused) {
    RunOptions before = last.options;
    before.from.clear();
    before.config.folder = refused.config.folder;
    before.difficulty = training::difficultyName(last.options.config.difficulty);
    return before;
}

}  // namespace

int run(const RunOptions& asked) {
    Ended last = runOne(asked, asked.begun);
    for (int number = 2; last.next && !interrupted(); ++number) {
        std::string refused;
        const RunOptions next = nextOptions(last, asked, number, refused);
        if (!refused.empty()) printMessage("instructor: " + refused);
        printMessage("beginning the next attempt");
        const SteadyTime begun = std::chrono::steady_clock::now();
        try {
            last = runOne(next, begun, refused);
        } catch (const std::runtime_error& e) {
            // The last attempt is stored. Its settings work, so the reason can be shown where the trainee
            // looks.
            const RunOptions before = optionsBefore(last, next);
            refused += fmt::format("{}. This attempt has the settings of the last one: {}.", e.what(),
                                   before.difficulty);
            printMessage("instructor: " + refused);
            last = runOne(before, begun, refused);
        }
    }
    return 0;
}

}  // namespace stylet::trainer
