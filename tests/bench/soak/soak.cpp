#include "tests/bench/soak/soak.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <random>
#include <thread>

#include <fmt/core.h>

#include "app/records/replay.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/loop/loops.h"
#include "app/trainer/program/results.h"
#include "app/trainer/session/attempt_writer.h"
#include "app/trainer/session/force_comparison.h"
#include "app/trainer/session/session_recorder.h"
#include "base/hash.h"
#include "patient/synth/synth.h"
#include "tests/bench/soak/soak_output.h"

namespace stylet::soak {

namespace fs = std::filesystem;
using namespace trainer;
using SteadyClock = std::chrono::steady_clock;

namespace {

// The scenarios of a round. The first ones together cover every tool, contrast medium, X-rays, breath holds
// and wrong punctures.
constexpr std::array kScenarios{
    "five-tools", "procedure", "trainee-reckless", "trainee-careless", "cholangiography",
    "wrong-tip",  "demo",      "demo-breathing",   "drainage"};
constexpr std::int64_t kMs = 1'000'000;
constexpr double kTeleport_m = 0.6;  // between two ticks: no hand moves that fast
constexpr const char* kTrainee = "soak";
constexpr int kMaxSendRetries = 20;
constexpr const char* kUnreachable = "host=/nowhere";  // a training centre that does not answer

fs::path assets() {
    const char* const folder = std::getenv("STYLET_ASSETS");
    if (!folder) throw DataError("STYLET_ASSETS", "environment", "names no folder");
    return folder;
}

struct SoakInput {
    explicit SoakInput(const Settings& settings)
        : seed(settings.seed),
          spacing_m(settings.spacing_m),
          breath(settings.breath),
          package(makePackage(settings)) {
        std::vector<patient::PlannedPath> paths = planPaths(patient, {}).paths;
        if (paths.empty()) throw DataError("the reference patient", "paths", "none");
        path = paths.front();
        for (const char* name : kScenarios)
            scenarios.push_back(loadScenario(assets() / "scenarios" / (std::string(name) + ".toml")));
        if (!breath.empty()) scenarios.push_back(recorded(scenarios.back(), breath));
    }
    // Extends the last stage by the length of the recording, so that the recording starts over.
    static Scenario recorded(Scenario scenario, const fs::path& csv) {
        scenario.name += "-recorded";
        breatheAsRecorded(scenario.breath, csv);
        const patient::BreathPlan& plan = scenario.breath.plan;
        scenario.stages.back().seconds += double(plan.recording_v.size()) * plan.recording_dt_s;
        return scenario;
    }
    static patient::Package makePackage(const Settings& settings) {
        patient::synth::SynthSettings synth;
        synth.seed = settings.seed;
        synth.spacing_m = settings.spacing_m;
        synth.defaults = patient::loadTissueDefaults(assets() / "tissue" / "ptcd.toml");
        return patient::synth::makeReferencePatient(synth);
    }
    const std::uint64_t seed;
    const double spacing_m;
    const fs::path breath;
    const patient::Package package;
    const patient::Patient patient{package};
    const std::uint64_t digest = patient::digest(package);
    const haptics::TouchMap touch = haptics::makeTouchMap(patient);
    const std::optional<OtherSegmentation> other = loadOtherSegmentation(patient, {});
    patient::PlannedPath path;
    std::vector<Scenario> scenarios;
};

// Caches the last input, so that a second soak with the same settings does not build the patient again.
const SoakInput& cachedInput(const Settings& settings) {
    static std::unique_ptr<SoakInput> last;
    if (!last || last->seed != settings.seed || last->spacing_m != settings.spacing_m ||
        last->breath != settings.breath)
        last = std::make_unique<SoakInput>(settings);
    return *last;
}

// The threads that Leak::thread leaks. The destructor ends them, so that the soak can report.
struct LeakedThreads {
    std::mutex mutex;
    std::condition_variable wake;
    bool over = false;
    std::vector<std::thread> threads;
    ~LeakedThreads() {
        {
            const std::lock_guard lock(mutex);
            over = true;
        }
        wake.notify_all();
        for (std::thread& thread : threads)
            thread.join();
    }
    void add() {
        threads.emplace_back([this] {
            std::unique_lock lock(mutex);
            wake.wait(lock, [this] { return over; });
        });
    }
};

class Soak {
  public:
    explicit Soak(const Settings& settings) : settings_(settings), input_(cachedInput(settings)) {}
    Result run();

  private:
    // How to run an attempt, and which equipment and services the trainee has.
    struct AttemptOptions {
        std::uint64_t seed = 0;
        const Retry* again = nullptr;  // retry from this bookmark
        bool seen = false;             // with a headset
        bool reachable = true;         // the training centre answers
        bool reported = false;
    };
    struct AttemptOutcome {
        fs::path folder;
        std::uint64_t hash = 0;
        std::size_t bookmarks = 0;
    };
    std::uint64_t round(std::uint64_t number, Latency* latency);
    std::uint64_t attempts(const Scenario&, std::uint64_t number, std::size_t i, Latency* latency);
    AttemptOutcome runAttempt(const Scenario&, const AttemptOptions&, Latency* latency);
    records::RecordInfo recordInfo(const Scenario&, const AttemptOptions&, double gain) const;
    records::AttemptInfo attemptInfo(const Scenario&, const AttemptOptions&, double gain) const;
    void addDisturbances(Attempt&, std::uint64_t seed) const;
    void onTick(const haptics::TickOutput&, Session&, UserOutput&);
    void checkAttempt(const Attempt&, const Scenario&, const SessionLog&, const LoopTotals&);
    void implausible(const std::string& why);
    void send(AttemptWriter&, bool reachable);
    void checkStored(const fs::path& folder, std::uint64_t hash);
    void leak();
    void recordResources(int threads);

    const Settings settings_;
    const SoakInput& input_;
    Result result_;
    Latency* latency_ = nullptr;
    double last_tick_us_ = 0.0;
    bool pause_ = true;  // skip the next latency sample, which includes more than a tick
    haptics::TickOutput before_;
    std::uint64_t leaked_ = 0;
    std::vector<std::unique_ptr<std::array<char, 4096>>> memory_;
    std::vector<int> descriptors_;
    LeakedThreads leaked_threads_;
};

// Adds events that no script contains: a jump of the device, faults with re-arming, and the instructor's
// commands.
void Soak::addDisturbances(Attempt& attempt, std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::vector<haptics::TraceSample>& hand = attempt.hand.samples;
    std::vector<haptics::TraceCommand>& commands = attempt.hand.commands;
    const std::int64_t end_ns = hand.back().t_ns;
    const auto someTime = [&] { return std::int64_t(random() % std::uint64_t(end_ns / kMs)) * kMs; };
    const auto insertCommand = [&](std::int64_t t_ns, const haptics::Command& command) {
        if (t_ns > end_ns) return;
        const auto later = [](std::int64_t t, const haptics::TraceCommand& c) { return t < c.t_ns; };
        commands.insert(std::upper_bound(commands.begin(), commands.end(), t_ns, later), {t_ns, command});
    };
    const auto schedule = [&](std::int64_t t_ns, haptics::CommandKind kind, std::uint32_t value = 0) {
        insertCommand(t_ns, {kind, value});
    };
    using enum haptics::CommandKind;
    for (const haptics::CommandKind kind : {cough, sigh, move, bleed})
        schedule(someTime(), kind);
    const std::int64_t dark_ns = someTime();
    schedule(dark_ns, lights, 0), schedule(dark_ns + 700 * kMs, lights, 1);
    insertCommand(someTime(), haptics::breathingCommand({0.5 + double(random() % 100) / 100.0, 1.2}));
    schedule(someTime(), marker, 3);
    // A fault removes the force. Every second attempt has no faults, so that it can succeed.
    if (seed % 2 == 0) {
        const std::int64_t failed_ns = someTime();
        schedule(failed_ns, fault), schedule(failed_ns + 600 * kMs, rearm);
        const std::size_t at = random() % hand.size();
        hand[at].device_from_stylus.position_m.x += kTeleport_m;
        schedule(hand[at].t_ns + 500 * kMs, rearm), schedule(hand[at].t_ns + 2500 * kMs, rearm);
    }
}

// Called after each tick, when the session has processed it.
void Soak::onTick(const haptics::TickOutput& now, Session& session, UserOutput& senses) {
    // From the last round on, each tick takes so much longer that a busy machine cannot hide it.
    if (settings_.leak == Leak::time && leaked_ > 1)
        for (std::uint64_t i = 0; i < 150'000; ++i)
            asm volatile("");
    if (latency_ && !pause_) latency_->add(threadTime_us() - last_tick_us_);
    pause_ = false;
    Counts& c = result_.counts;
    ++c.tools[std::size_t(now.tool)];
    c.guided += now.needle_in_guide;
    c.holds += now.breath_held && !before_.breath_held;
    c.faults += now.faults != 0 && before_.faults == 0;
    c.rearmed += now.level > 0.0 && before_.level == 0.0 && now.tick > 3000;
    if (now.incision_count > before_.incision_count) ++c.incisions;
    before_ = now;
    if (now.tick % 7000 == 3000) {
        session.note("bookmark", "soak");
        ++c.bookmarks;
        pause_ = true;  // the bookmark was written to disk
    }
    if (senses.wants(now)) {
        senses.playSounds(session.frameState(now));
        pause_ = true;
    }
    if (latency_) last_tick_us_ = threadTime_us();
}

void Soak::implausible(const std::string& why) {
    Counts& c = result_.counts;
    if (c.implausible.size() < 20)
        c.implausible.push_back("attempt " + std::to_string(c.attempts) + ": " + why);
}

void Soak::checkAttempt(const Attempt& attempt, const Scenario& scenario, const SessionLog& log,
                        const LoopTotals& totals) {
    Counts& c = result_.counts;
    if (!(log.score.total >= 0.0 && log.score.total <= 100.0)) implausible("a score outside of 0 to 100");
    if (!(log.peak_force_n >= 0.0 && log.peak_force_n < 100.0)) implausible("a force that cannot be");
    if (log.ticks != attempt.beginning.size() + totals.haptics.ticks || log.last_tick + 1 < log.ticks)
        implausible("ticks were lost");
    if (totals.flights_missed > 0) implausible("a fault without its history");
    if (log.dose.contrast_m3 < 0.0 || !(log.dose.air_kerma_gy >= 0.0)) implausible("a dose below zero");
    for (const report::ForceSample& sample : log.curve)
        if (!std::isfinite(sample.force_n) || !std::isfinite(sample.depth_m)) {
            implausible("a number that is none on the force curve");
            break;
        }
    ++c.attempts;
    c.ticks += log.ticks;
    const patient::BreathPlan& breath = scenario.breath.plan;
    if (!breath.recording_v.empty())
        c.recordings += std::uint64_t(double(log.ticks) * attempt.simulation.dt_s /
                                      (double(breath.recording_v.size()) * breath.recording_dt_s));
    c.hits += log.target_hit();
    c.cuts += log.punctures.size();
    c.wrong_cuts += log.progress.risk_hits;
    c.pulses += log.dose.pulses;
    c.contrast_ml += 1e6 * log.dose.contrast_m3;
}

// Replays the stored record as `stylet replay` does, and compares the hashes.
void Soak::checkStored(const fs::path& folder, std::uint64_t hash) {
    const records::Record record = records::loadRecord(folder / "record");
    const records::ReplayResult again = records::replay(input_.patient, record, nullptr);
    if (!again.equal() || again.state_hash != hash) implausible("its record replays to another hash");
    ++result_.counts.replayed;
}

void Soak::leak() {
    ++leaked_;
    switch (settings_.leak) {
        case Leak::none:
        case Leak::time:
        case Leak::state:
            return;
        case Leak::memory:
            for (int i = 0; i < 25; ++i)
                memory_.push_back(std::make_unique<std::array<char, 4096>>());
            return;
        case Leak::descriptor:
            descriptors_.push_back(leakDescriptor());
            return;
        case Leak::region:
            leakRegions();
            return;
        case Leak::thread:
            leaked_threads_.add();
            return;
    }
}

records::RecordInfo Soak::recordInfo(const Scenario& scenario, const AttemptOptions& options,
                                     double gain) const {
    records::RecordInfo info;
    info.program_version = STYLET_VERSION, info.patient_name = input_.package.name;
    info.scenario = scenario.name, info.seed = options.seed, info.gain = gain, info.path = input_.path;
    info.device = "scripted", info.clock = "virtual";
    info.difficulty = training::kDifficultyNames[options.seed % 3];
    if (options.again) {
        const std::vector<records::Bookmark>& marks = options.again->record.info.bookmarks;
        info.bookmarks.assign(marks.begin(), marks.begin() + std::ptrdiff_t(options.again->number));
    }
    return info;
}

records::AttemptInfo Soak::attemptInfo(const Scenario& scenario, const AttemptOptions& options,
                                       double gain) const {
    records::AttemptInfo info;
    info.trainee = kTrainee, info.device = "scripted", info.patient = input_.package.name;
    info.scenario = scenario.name, info.program_version = STYLET_VERSION;
    info.difficulty = training::kDifficultyNames[options.seed % 3];
    info.patient_digest = input_.digest, info.seed = options.seed, info.device_gain = gain;
    return info;
}

// Sends to the training centre. If it is unreachable, unsent data is no error.
void Soak::send(AttemptWriter& attempt_writer, bool reachable) {
    if (settings_.centre.empty()) return;
    std::size_t left = attempt_writer.send();
    for (int again = 0; reachable && left > 0 && again < kMaxSendRetries; ++again)
        left = attempt_writer.send();  // a busy machine can need several sends
    result_.counts.sent += left == 0, result_.counts.unsent += left > 0;
    if (reachable && left > 0) implausible("the training centre did not get it");
}

// Assembles and runs an attempt as run.cpp does.
Soak::AttemptOutcome Soak::runAttempt(const Scenario& scenario, const AttemptOptions& options,
                                      Latency* latency) {
    const MakeTouch touch = [&](const patient::Patient&) { return input_.touch; };
    Attempt attempt = makeAttempt(input_.patient, scenario, input_.path, options.seed, 1000.0, touch);
    addDisturbances(attempt, options.seed + (options.again ? 2 : 0));
    if (options.again) startFromRecord(attempt, *options.again, touch);
    result_.counts.commands += attempt.hand.commands.size();
    const double gain = haptics::outputGain(attempt.simulation.profile, attempt.simulation.output);
    const auto logged = [this](const std::string&) { ++result_.counts.logged; };
    AttemptWriter attempt_writer(
        settings_.folder, settings_.centre.empty() || options.reachable ? settings_.centre : kUnreachable,
        logged);
    const records::StoredAttempt begun = attempt_writer.begin(attemptInfo(scenario, options, gain));
    const fs::path& folder = begun.folder;
    const auto difficulty = training::Difficulty(options.seed % 3);
    UserOutput senses({attempt, input_.path, difficulty, folder, options.seen ? settings_.fps : 0.0, logged},
                      result_.counts);
    records::RecordInfo info = recordInfo(scenario, options, gain);
    info.id = begun.id, info.trainee = begun.info.trainee, info.started_utc = begun.started_utc;
    records::RecordWriter writer(folder / "record", {input_.digest, attempt.simulation}, info);
    SessionRecorder recorder(folder / "record", {input_.digest, attempt.simulation.dt_s}, writer);
    Session session(input_.patient, input_.path, scenario.moments, scenario.approach_distance_m, &writer);
    session.setDifficulty(difficulty);
    if (options.again) session.note("retry", "bookmark " + std::to_string(options.again->number));
    std::optional<ForceComparison> truth;
    if (input_.other) session.compareWith(truth.emplace(*input_.other, attempt.simulation.tools.needle));
    before_ = {};
    pause_ = true;
    latency_ = latency;
    session.setWatcher([&](const haptics::TickOutput& now, const SessionLog& log) {
        recorder.update(now, log);
        attempt_writer.keep();
        onTick(now, session, senses);
    });
    session.setNoteWatcher([&](const SessionLog& log) { recorder.writeEvents(log); });
    const LoopTotals totals =
        runFast(attempt, session, senses.display([this] { pause_ = true; }), senses.fps(), {});
    recorder.finish(session.log(), makeResult(input_.patient, session.log(), totals, false));
    checkAttempt(attempt, scenario, session.log(), totals);
    const std::uint64_t hash = session.log().state_hash;
    if (options.reported) {
        const AttemptFacts facts{input_.package.name, {},          scenario.name, options.seed,
                                 "virtual",           input_.path, 0.001,         "soak"};
        writeResults({input_.patient, facts, writer.info()}, session.log(), totals, folder);
        checkStored(folder, hash);
    }
    attempt_writer.finish();
    send(attempt_writer, options.reachable);
    return {folder, hash, writer.info().bookmarks.size()};
}

// Runs one attempt of a round, and perhaps retries it from a bookmark. Then erases the trainee's data.
std::uint64_t Soak::attempts(const Scenario& scenario, std::uint64_t number, std::size_t i,
                             Latency* latency) {
    const std::size_t count = std::min(settings_.scenarios, input_.scenarios.size());
    const auto turn = [&](std::size_t which) { return which < count && (number + which) % count == i; };
    AttemptOptions options;
    options.seed = settings_.seed + 1000 * number + i + number;
    options.seen = settings_.pictures && turn(0);
    options.reported = turn(1);
    options.reachable = !turn(1);
    const AttemptOutcome made = runAttempt(scenario, options, latency);
    StateHash hash;
    hash.add(made.hash);
    if (turn(2) && made.bookmarks > 0) {
        Retry again = openRetry(made.folder.string() + "@" + std::to_string((made.bookmarks + 1) / 2),
                                settings_.folder);
        checkRetry(again, input_.patient);
        options.again = &again, options.seen = options.reported = false, options.reachable = true;
        hash.add(runAttempt(scenario, options, nullptr).hash);
        ++result_.counts.retries;
    }
    result_.counts.stored += records::Store(settings_.folder).eraseTrainee(kTrainee);
    leak();
    if (settings_.leak == Leak::state) hash.add(leaked_);
    return hash.value();
}

std::uint64_t Soak::round(std::uint64_t number, Latency* latency) {
    StateHash hash;
    for (std::size_t i = 0; i < std::min(settings_.scenarios, input_.scenarios.size()); ++i)
        hash.add(attempts(input_.scenarios[i], number, i, latency));
    return hash.value();
}

// Records the resources in use after a round.
void Soak::recordResources(int threads) {
    result_.resources.push_back(measureResources(threads, settings_.timeout));
    result_.resources.back().headsets = result_.counts.headsets;
}

Result Soak::run() {
    limitHeapArenas();
    prepareUserOutput(settings_.folder, input_.patient, input_.path);
    const SteadyClock::time_point begin = SteadyClock::now();
    // The first round warms everything up. Its tick count determines the number of rounds.
    std::uint64_t first_hash = round(0, nullptr);
    const std::uint64_t ticks = result_.counts.ticks;
    result_.rounds = std::max<std::size_t>(3, std::size_t((settings_.ticks + ticks - 1) / ticks));
    result_.compared = std::max<std::size_t>(1, result_.rounds / 10);
    result_.hashes.reserve(result_.rounds), result_.resources.reserve(result_.rounds);
    result_.counts.implausible.reserve(32);
    result_.hashes.push_back(first_hash), recordResources(0);
    StateHash all;
    all.add(first_hash);
    // The first round is the warm-up. The rounds from the second on are repeated at the end.
    const std::size_t repeats = std::min(result_.compared, result_.rounds - 2);
    result_.compared = repeats;
    for (std::size_t i = 1; i < result_.rounds; ++i) {
        const std::size_t left = result_.rounds - i;
        const bool early = i <= repeats, late = left <= repeats;
        const std::size_t number = late ? i - (result_.rounds - repeats) + 1 : i;
        const std::uint64_t hash = round(number, early ? &result_.first : late ? &result_.last : nullptr);
        all.add(hash);
        result_.hashes.push_back(hash), recordResources(result_.resources.front().threads);
        if (i % std::max<std::size_t>(1, result_.rounds / 20) == 0) {
            settings_.log(
                fmt::format("round {} of {}, {:.3g} ticks, {:.0f} s, heap {:.2f} MB, resident {:.1f} MB",
                            i + 1, result_.rounds, double(result_.counts.ticks),
                            std::chrono::duration<double>(SteadyClock::now() - begin).count(),
                            1e-6 * double(result_.resources.back().heap_bytes),
                            1e-6 * double(result_.resources.back().resident_bytes)));
        }
    }
    result_.state_hash = all.value();
    result_.seconds = std::chrono::duration<double>(SteadyClock::now() - begin).count();
    return std::move(result_);
}

}  // namespace

Result soak(const Settings& settings) {
    return std::make_unique<Soak>(settings)->run();
}

}  // namespace stylet::soak
