#include "tests/bench/soak.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <thread>

#include "app/records/replay.h"
#include "app/trainer/force_truth.h"
#include "app/trainer/guide_panel.h"
#include "app/trainer/keeper.h"
#include "app/trainer/loops.h"
#include "app/trainer/monitor.h"
#include "app/trainer/notice.h"
#include "app/trainer/results.h"
#include "app/trainer/sound/cues.h"
#include "patient/hash.h"
#include "patient/synth/synth.h"

namespace stylet::soak {

namespace fs = std::filesystem;
using namespace trainer;
using SteadyClock = std::chrono::steady_clock;

namespace {

// A round, the first of which have a bit of all: every tool, contrast medium and X-rays, holds, wrong
// punctures.
constexpr std::array kScenarios{
    "five-tools", "procedure", "trainee-reckless", "trainee-careless", "cholangiography",
    "wrong-tip",  "demo",      "demo-breathing"};
constexpr double kFps = 0.2;  // of the virtual clock: what a picture would show is made so often
constexpr std::uint64_t kMachinesEvery = 7;  // attempts: an X-ray picture in software takes long
constexpr std::int64_t kMs = 1'000'000;
constexpr double kLeap_m = 0.6;  // between two ticks: no hand does that
// A driver makes what it needs when it is first needed, which may be late.
constexpr std::uint64_t kHeapSlack = 64 << 10, kDriverSlack = 1 << 20, kResidentSlack = 16 << 20;

fs::path assets() {
    const char* const folder = std::getenv("STYLET_ASSETS");
    if (!folder) throw patient::DataError("STYLET_ASSETS", "environment", "names no folder");
    return folder;
}

struct Bed {
    explicit Bed(const Settings& settings)
        : seed(settings.seed), spacing_m(settings.spacing_m), package(made(settings)) {
        std::vector<patient::PlannedPath> paths = planPaths(patient, {}).paths;
        if (paths.empty()) throw patient::DataError("the reference patient", "paths", "none");
        path = paths.front();
        for (const char* name : kScenarios)
            scenarios.push_back(loadScenario(assets() / "scenarios" / (std::string(name) + ".toml")));
    }
    static patient::Package made(const Settings& settings) {
        patient::synth::SynthSettings synth;
        synth.seed = settings.seed;
        synth.spacing_m = settings.spacing_m;
        synth.defaults = patient::loadTissueDefaults(assets() / "tissue" / "ptcd.toml");
        return patient::synth::makeReferencePatient(synth);
    }
    const std::uint64_t seed;
    const double spacing_m;
    const patient::Package package;
    const patient::Patient patient{package};
    const std::uint64_t digest = patient::digest(package);
    const haptics::TouchMap touch = haptics::makeTouchMap(patient);
    const std::optional<OtherSegmentation> other = otherSegmentation(patient, {});
    patient::PlannedPath path;
    std::vector<Scenario> scenarios;
};

// The last one stays: who soaks twice is spared a second patient.
const Bed& bedOf(const Settings& settings) {
    static std::unique_ptr<Bed> last;
    if (!last || last->seed != settings.seed || last->spacing_m != settings.spacing_m)
        last = std::make_unique<Bed>(settings);
    return *last;
}

// What Leak::thread leaves behind; let go at the end, so that the soak can report.
struct Sleepers {
    std::mutex mutex;
    std::condition_variable wake;
    bool over = false;
    std::vector<std::thread> threads;
    ~Sleepers() {
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
    explicit Soak(const Settings& settings) : settings_(settings), bed_(bedOf(settings)) {}
    Result run();

  private:
    std::uint64_t round(std::uint64_t number, Latency* latency);
    std::uint64_t attempt(const Scenario&, std::uint64_t seed, bool shown, Latency* latency);
    void unsettle(Attempt&, std::uint64_t seed) const;
    void watch(const haptics::TickOutput&, Session&);
    Pictures pictures(const Attempt&);
    void judge(const Scenario&, const SessionLog&, const LoopTotals&);
    void checkStored(const fs::path& folder, std::uint64_t hash);
    void leak();

    const Settings settings_;
    const Bed& bed_;
    Result result_;
    Latency* latency_ = nullptr;
    SteadyClock::time_point last_tick_{};
    bool pause_ = true;  // what follows was no tick's
    haptics::TickOutput before_;
    std::uint64_t leaked_ = 0;
    std::vector<std::unique_ptr<std::array<char, 4096>>> memory_;
    std::vector<int> descriptors_;
    Sleepers sleepers_;
    std::optional<MachineView> machines_;
};

// What no script has: a leap of the device, faults and their re-arming, all that an instructor may do.
void Soak::unsettle(Attempt& attempt, std::uint64_t seed) const {
    std::mt19937_64 random(seed);
    std::vector<haptics::TraceSample>& hand = attempt.hand.samples;
    std::vector<haptics::TraceCommand>& commands = attempt.hand.commands;
    const std::int64_t end_ns = hand.back().t_ns;
    const auto someTime = [&] { return std::int64_t(random() % std::uint64_t(end_ns / kMs)) * kMs; };
    const auto give = [&](std::int64_t t_ns, const haptics::Command& command) {
        if (t_ns > end_ns) return;
        const auto later = [](std::int64_t t, const haptics::TraceCommand& c) { return t < c.t_ns; };
        commands.insert(std::upper_bound(commands.begin(), commands.end(), t_ns, later), {t_ns, command});
    };
    const auto say = [&](std::int64_t t_ns, haptics::CommandKind kind, std::uint32_t value = 0) {
        give(t_ns, {kind, value});
    };
    using enum haptics::CommandKind;
    for (const haptics::CommandKind kind : {cough, sigh, move, bleed})
        say(someTime(), kind);
    const std::int64_t dark_ns = someTime();
    say(dark_ns, lights, 0), say(dark_ns + 700 * kMs, lights, 1);
    give(someTime(), haptics::breathingCommand({0.5 + double(random() % 100) / 100.0, 1.2}));
    say(someTime(), marker, 3);
    // A fault takes the force away: each second attempt is left in peace, so that it can succeed.
    if (seed % 2 == 0) {
        const std::int64_t failed_ns = someTime();
        say(failed_ns, fault), say(failed_ns + 600 * kMs, rearm);
        const std::size_t at = random() % hand.size();
        hand[at].device_from_stylus.position_m.x += kLeap_m;
        say(hand[at].t_ns + 500 * kMs, rearm), say(hand[at].t_ns + 2500 * kMs, rearm);
    }
}

// Each tick, once all that comes of it is done.
void Soak::watch(const haptics::TickOutput& now, Session& session) {
    if (settings_.leak == Leak::time)
        for (std::uint64_t i = 0; i < 20'000 * leaked_ * leaked_ * leaked_ * leaked_; ++i)
            asm volatile("");
    const SteadyClock::time_point here = SteadyClock::now();
    if (latency_ && !pause_)
        latency_->add(std::chrono::duration<double, std::micro>(here - last_tick_).count());
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
        pause_ = true;  // it is on the disk now
    }
    last_tick_ = SteadyClock::now();
}

// What eyes and ears would be given.
Pictures Soak::pictures(const Attempt& attempt) {
    constexpr auto kHelp = training::Difficulty::guided;
    struct Given {
        Given(const SoundPlaces& places, double tick_s)
            : panel(training::hintsOf(kHelp), tick_s), alerts(tick_s), cues(places, kHelp, tick_s) {}
        GuidePanel panel;
        AlertWatch alerts;
        Cues cues;
        BreathMonitor monitor;
    };
    const double tick_s = attempt.simulation.dt_s;
    const auto given = std::make_shared<Given>(soundPlaces(bed_.patient, bed_.path), tick_s);
    Pictures pictures;
    pictures.totals = [] { return PictureTotals{}; };
    pictures.frame = [this, given, tick_s, guide = attempt.simulation.tools.guide,
                      left = machines_ && result_.counts.attempts % kMachinesEvery == 0 ? 1 : 0](
                         const Seen& seen, const patient::ContrastTable* contrast,
                         const std::string&) mutable {
        const double t_s = tick_s * double(seen.tick.tick);
        given->panel.take(seen, true);
        given->cues.take(seen);
        given->monitor.take(t_s, seen.tick.breath, seen.tick.breath_held);
        result_.counts.alerts += given->alerts.take(seen).has_value();
        result_.counts.alerts += noticeOf(seen, Attention::focused, "").has_value();
        ++result_.counts.hints;
        if (left > 0 && t_s >= 15.0) {
            --left;
            MachineMoment moment = momentOf(seen.tick, guide, tick_s);
            moment.patient_from_isocentre.position_m = isocentreFor(bed_.path);
            moment.contrast = contrast;
            moment.machines = seen.machines, moment.dose = seen.dose;
            machines_->ultrasound(moment);
            machines_->xray(moment);
            result_.counts.pictures += 2;
        }
        pause_ = true;
        return true;
    };
    return pictures;
}

void Soak::judge(const Scenario& scenario, const SessionLog& log, const LoopTotals& totals) {
    Counts& c = result_.counts;
    const auto insane = [&](const std::string& why) {
        if (c.insane.size() < 20)
            c.insane.push_back(scenario.name + ", attempt " + std::to_string(c.attempts) + ": " + why);
    };
    if (!(log.score.total >= 0.0 && log.score.total <= 100.0)) insane("a score outside of 0 to 100");
    if (!(log.peak_force_n >= 0.0 && log.peak_force_n < 100.0)) insane("a force that cannot be");
    if (log.ticks != totals.haptics.ticks || log.last_tick + 1 < log.ticks) insane("ticks were lost");
    if (totals.flights_missed > 0) insane("a fault without its history");
    if (log.dose.contrast_m3 < 0.0 || !(log.dose.air_kerma_gy >= 0.0)) insane("a dose below zero");
    for (const report::ForceSample& sample : log.curve)
        if (!std::isfinite(sample.force_n) || !std::isfinite(sample.depth_m)) {
            insane("a number that is none on the force curve");
            break;
        }
    ++c.attempts;
    c.ticks += log.ticks;
    c.hits += log.target_hit();
    c.cuts += log.punctures.size();
    c.wrong_cuts += log.progress.risk_hits;
    c.pulses += log.dose.pulses;
    c.contrast_ml += 1e6 * log.dose.contrast_m3;
}

// As `stylet replay` would find it.
void Soak::checkStored(const fs::path& folder, std::uint64_t hash) {
    const records::Record record = records::loadRecord(folder / "record");
    const records::ReplayResult again = records::replay(bed_.patient, record, nullptr);
    if (!again.equal() || again.state_hash != hash)
        result_.counts.insane.push_back("a record replays to another hash: " + folder.string());
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
            descriptors_.push_back(openNothing());
            return;
        case Leak::thread:
            sleepers_.add();
            return;
    }
}

std::uint64_t Soak::attempt(const Scenario& scenario, std::uint64_t seed, bool shown, Latency* latency) {
    const std::string trainee = "soak";
    std::uint64_t hash = 0;
    {
        Attempt attempt = makeAttempt(bed_.patient, scenario, bed_.path, seed, 1000.0,
                                      [&](const patient::Patient&) { return bed_.touch; });
        unsettle(attempt, seed);
        result_.counts.commands += attempt.hand.commands.size();
        const double gain = haptics::outputGain(attempt.simulation.profile, attempt.simulation.output);
        Keeper keeper(settings_.folder, "", settings_.say);
        records::AttemptInfo stored;
        stored.trainee = trainee, stored.device = "scripted", stored.patient = bed_.package.name;
        stored.scenario = scenario.name, stored.difficulty = "practice",
        stored.program_version = STYLET_VERSION;
        stored.patient_digest = bed_.digest, stored.seed = seed, stored.device_gain = gain;
        const fs::path folder = keeper.begin(stored);
        records::RecordInfo info;
        info.program_version = STYLET_VERSION, info.patient_name = bed_.package.name;
        info.scenario = scenario.name, info.seed = seed, info.gain = gain, info.path = bed_.path;
        records::RecordWriter writer(folder / "record", {bed_.digest, attempt.simulation}, info);
        Session session(bed_.patient, bed_.path, scenario.moments, scenario.approach_distance_m, &writer);
        std::optional<ForceTruth> truth;
        if (bed_.other) session.compareWith(truth.emplace(*bed_.other, attempt.simulation.tools.needle));
        session.setDifficulty(training::Difficulty(seed % 3));
        before_ = {};
        pause_ = true;
        latency_ = latency;
        session.setWatcher([&](const haptics::TickOutput& now, const SessionLog& log) {
            keeper.take(now, log);
            watch(now, session);
        });
        session.setNoteWatcher([&](const SessionLog& log) { keeper.storeEvents(log); });
        const LoopTotals totals = runFast(attempt, session, pictures(attempt), kFps, {});
        writer.finish();
        judge(scenario, session.log(), totals);
        hash = session.log().state_hash;
        if (shown) {
            const AttemptFacts facts{bed_.package.name, {},        scenario.name, seed,
                                     "virtual",         bed_.path, 0.001,         "soak"};
            writeResults(bed_.patient, facts, session.log(), totals, folder);
            checkStored(folder, hash);
        }
        keeper.finish(session.log());
    }
    result_.counts.stored += records::Store(settings_.folder).eraseTrainee(trainee);
    leak();
    if (settings_.leak == Leak::state) hash += leaked_;
    return hash;
}

std::uint64_t Soak::round(std::uint64_t number, Latency* latency) {
    patient::StateHash hash;
    for (std::size_t i = 0; i < std::min(settings_.scenarios, bed_.scenarios.size()); ++i)
        hash.add(attempt(bed_.scenarios[i], settings_.seed + 1000 * number + i + number,
                         i == 0 && number % 10 == 0, latency));
    return hash.value();
}

Result Soak::run() {
    if (settings_.machines) {
        std::string why_not;
        machines_ = openMachines(bed_.patient, assets(), why_not);
        if (!machines_) throw patient::DataError("--machines", "pictures", why_not);
    }
    const SteadyClock::time_point begin = SteadyClock::now();
    // How many there are is known after the first, which is also what warms everything up.
    std::uint64_t first_hash = round(0, nullptr);
    const std::uint64_t ticks = result_.counts.ticks;
    result_.rounds = std::max<std::size_t>(3, std::size_t((settings_.ticks + ticks - 1) / ticks));
    result_.compared = std::max<std::size_t>(1, result_.rounds / 10);
    result_.hashes.reserve(result_.rounds), result_.held.reserve(result_.rounds);
    result_.counts.insane.reserve(32);
    result_.hashes.push_back(first_hash), result_.held.push_back(heldNow());
    patient::StateHash all;
    all.add(first_hash);
    // The first is the warmer: those from the second on are made again at the end.
    const std::size_t repeats = std::min(result_.compared, result_.rounds - 2);
    result_.compared = repeats;
    for (std::size_t i = 1; i < result_.rounds; ++i) {
        const std::size_t left = result_.rounds - i;
        const bool early = i <= repeats, late = left <= repeats;
        const std::size_t number = late ? i - (result_.rounds - repeats) + 1 : i;
        const std::uint64_t hash = round(number, early ? &result_.first : late ? &result_.last : nullptr);
        all.add(hash);
        result_.hashes.push_back(hash), result_.held.push_back(heldNow());
        if (i % std::max<std::size_t>(1, result_.rounds / 20) == 0) {
            char line[160];
            std::snprintf(line, sizeof line,
                          "round %zu of %zu, %.3g ticks, %.0f s, heap %.2f MB, resident %.1f MB", i + 1,
                          result_.rounds, double(result_.counts.ticks),
                          std::chrono::duration<double>(SteadyClock::now() - begin).count(),
                          1e-6 * double(result_.held.back().heap_bytes),
                          1e-6 * double(result_.held.back().resident_bytes));
            settings_.say(line);
        }
    }
    result_.state_hash = all.value();
    result_.seconds = std::chrono::duration<double>(SteadyClock::now() - begin).count();
    return std::move(result_);
}

}  // namespace

double Latency::quantile_us(double share) const {
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < bins_.size(); ++i) {
        below += bins_[i];
        if (double(below) >= share * double(count_)) return double(i + 1) / kBinsAMicrosecond;
    }
    return most_us_;
}

Result soak(const Settings& settings) {
    return std::make_unique<Soak>(settings)->run();
}

std::vector<std::string> complaintsOf(const Result& r, const Settings& settings) {
    std::vector<std::string> bad = r.counts.insane;
    const Held &then = r.held[r.compared], &now = r.held.back();
    const auto grew = [&](const char* what, double from, double to, double slack) {
        if (to <= from + slack) return;
        char line[160];
        std::snprintf(line, sizeof line, "%s grew from %.0f to %.0f", what, from, to);
        bad.emplace_back(line);
    };
    grew("the heap in use", double(then.heap_bytes), double(now.heap_bytes),
         double(settings.machines ? kDriverSlack : kHeapSlack));
    grew("resident memory", double(then.resident_bytes), double(now.resident_bytes), double(kResidentSlack));
    grew("open descriptors", then.descriptors, now.descriptors, 0.0);
    grew("threads", then.threads, now.threads, 0.0);
    for (const double share : {0.5, 0.9})
        if (r.last.quantile_us(share) > settings.most_slower * r.first.quantile_us(share) + 0.1) {
            char line[160];
            std::snprintf(line, sizeof line, "a tick at the %.0f %% quantile took %.2f us, now %.2f us",
                          100.0 * share, r.first.quantile_us(share), r.last.quantile_us(share));
            bad.emplace_back(line);
        }
    for (std::size_t i = 0; i < r.compared; ++i)
        if (r.hashes[1 + i] != r.hashes[r.rounds - r.compared + i])
            bad.push_back("round " + std::to_string(2 + i) + " made again ends in another hash");
    const Counts& c = r.counts;
    const auto needed = [&](const char* what, bool there) {
        if (!there) bad.push_back(std::string("nothing was soaked: no ") + what);
    };
    needed("hit", c.hits > 0), needed("wrong puncture", c.wrong_cuts > 0), needed("hold", c.holds > 0);
    needed("incision", c.incisions > 0), needed("needle in the guide", c.guided > 0);
    needed("fault", c.faults > 0), needed("re-arming", c.rearmed > 0), needed("X-ray pulse", c.pulses > 0);
    needed("contrast medium", c.contrast_ml > 0.0), needed("bookmark", c.bookmarks > 0);
    needed("alert", c.alerts > 0), needed("hint", c.hints > 0), needed("replayed record", c.replayed > 0);
    needed("stored attempt", c.stored == c.attempts);
    needed("five tools", std::find(c.tools.begin(), c.tools.end(), 0u) == c.tools.end());
    return bad;
}

std::string reportOf(const Result& r) {
    const Counts& c = r.counts;
    const Held &then = r.held[r.compared], &now = r.held.back();
    char text[2400];
    std::snprintf(
        text, sizeof text,
        "soak: %llu ticks, %llu attempts in %zu rounds, %.0f s: %.2f us a tick with everything\n"
        "  done       %llu hits, %llu cuts, %llu of structures at risk, %llu holds, %llu incisions, %llu "
        "ticks in the "
        "guide, %llu faults, %llu starts of the force,\n"
        "             %llu commands, %llu X-ray pulses, %.0f ml of contrast medium, %llu bookmarks, %llu "
        "hint "
        "panels, %llu alerts, %llu machine pictures, %llu records replayed, %llu stored\n"
        "             ticks with finger, probe, scalpel, guide, needle in hand: %llu, %llu, %llu, %llu, "
        "%llu\n"
        "  held       after round %zu -> at the end\n"
        "    heap     %.3f -> %.3f MB\n    resident %.1f -> %.1f MB\n    handles  %d -> %d\n    threads  %d "
        "-> %d\n"
        "  a tick     the same %zu rounds at the beginning -> at the end [us]\n"
        "    50 %%     %.2f -> %.2f\n    90 %%     %.2f -> %.2f\n    99 %%     %.2f -> %.2f\n    99.9 %%   "
        "%.2f -> "
        "%.2f\n    longest  %.0f -> %.0f\n"
        "  state hash %016llx\n",
        static_cast<unsigned long long>(c.ticks), static_cast<unsigned long long>(c.attempts), r.rounds,
        r.seconds, 1e6 * r.seconds / double(c.ticks), static_cast<unsigned long long>(c.hits),
        static_cast<unsigned long long>(c.cuts), static_cast<unsigned long long>(c.wrong_cuts),
        static_cast<unsigned long long>(c.holds), static_cast<unsigned long long>(c.incisions),
        static_cast<unsigned long long>(c.guided), static_cast<unsigned long long>(c.faults),
        static_cast<unsigned long long>(c.rearmed), static_cast<unsigned long long>(c.commands),
        static_cast<unsigned long long>(c.pulses), c.contrast_ml,
        static_cast<unsigned long long>(c.bookmarks), static_cast<unsigned long long>(c.hints),
        static_cast<unsigned long long>(c.alerts), static_cast<unsigned long long>(c.pictures),
        static_cast<unsigned long long>(c.replayed), static_cast<unsigned long long>(c.stored),
        static_cast<unsigned long long>(c.tools[0]), static_cast<unsigned long long>(c.tools[1]),
        static_cast<unsigned long long>(c.tools[2]), static_cast<unsigned long long>(c.tools[3]),
        static_cast<unsigned long long>(c.tools[4]), r.compared + 1, 1e-6 * double(then.heap_bytes),
        1e-6 * double(now.heap_bytes), 1e-6 * double(then.resident_bytes), 1e-6 * double(now.resident_bytes),
        then.descriptors, now.descriptors, then.threads, now.threads, r.compared, r.first.quantile_us(0.5),
        r.last.quantile_us(0.5), r.first.quantile_us(0.9), r.last.quantile_us(0.9), r.first.quantile_us(0.99),
        r.last.quantile_us(0.99), r.first.quantile_us(0.999), r.last.quantile_us(0.999), r.first.most_us(),
        r.last.most_us(), static_cast<unsigned long long>(r.state_hash));
    return text;
}

void writeJson(const Result& r, const Settings& settings, const fs::path& file) {
    nlohmann::ordered_json held = nlohmann::json::array();
    for (const Held& h : r.held)
        held.push_back({h.heap_bytes, h.resident_bytes, h.descriptors, h.threads});
    const auto times = [](const Latency& l) {
        return nlohmann::ordered_json{{"p50", l.quantile_us(0.5)},
                                      {"p90", l.quantile_us(0.9)},
                                      {"p99", l.quantile_us(0.99)},
                                      {"p999", l.quantile_us(0.999)},
                                      {"longest", l.most_us()}};
    };
    const nlohmann::ordered_json json{
        {"seed", settings.seed},
        {"ticks", r.counts.ticks},
        {"attempts", r.counts.attempts},
        {"seconds", r.seconds},
        {"tick_us_first", times(r.first)},
        {"tick_us_last", times(r.last)},
        {"state_hash", records::hexOf(r.state_hash)},
        {"complaints", complaintsOf(r, settings)},
        {"held_fields", {"heap_bytes", "resident_bytes", "descriptors", "threads"}},
        {"held_after_each_round", held}};
    std::ofstream out(file);
    out << json.dump(1) << '\n';
    if (!out) throw patient::DataError(file, "file", "cannot be written");
}

}  // namespace stylet::soak
