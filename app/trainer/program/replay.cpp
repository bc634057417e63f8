#include "app/trainer/program/replay.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <optional>

#include "app/records/replay.h"
#include "app/records/samples.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/attempt/retry.h"
#include "app/trainer/display/replay_show.h"
#include "app/trainer/program/results.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/folder_linux.h"
#include "base/hex.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

namespace {

void reportDamage(const records::Record& record) {
    if (record.torn_bytes > 0)
        printMessage(fmt::format("the record is damaged: {} bytes after its last complete frame were removed",
                                 record.torn_bytes));
    if (record.info.lost)
        printMessage(fmt::format("ticks {} to {} were lost during recording; the record ends there",
                                 record.info.lost->first, record.info.lost->last));
    if (!record.info.end) printMessage("the attempt was cut short; replaying the recorded part");
}

// Compares the stored samples of an attempt with the recomputed ones.
class StoredSamples {
  public:
    StoredSamples(const std::filesystem::path& folder, bool cut_short)
        : may_be_missing_(cut_short ? records::kSyncTicks + records::kFrameTicks : 0) {
        const std::filesystem::path file = folder / "samples.bin";
        if (!std::filesystem::exists(file)) {
            problem_ = "missing, ";
            return;
        }
        try {
            stored_ = records::loadSamples(folder);
            if (stored_.torn_bytes > 0)
                problem_ = fmt::format("damaged from byte {}, ",
                                       std::filesystem::file_size(file) - stored_.torn_bytes);
        } catch (const DataError& e) {
            if (!cut_short) throw;  // the header may be incomplete because the program was killed
            problem_ = "damaged from byte 0, ";
            printMessage(e.what());
        }
    }
    void compare(const records::Sample& recomputed) {
        if (compared_ == stored_.samples.size()) return;
        if (recomputed.tick < stored_.samples[compared_].tick) return;  // the sample of this tick is missing
        if (!differs_at_ && !records::equalWhenEncoded(recomputed, stored_.samples[compared_]))
            differs_at_ = recomputed.tick;
        ++compared_;
    }
    // Prints the result. Returns false if a sample differs, or if one of the `ticks` recomputed ticks has no
    // sample although the attempt was not cut short before it was written.
    bool report(std::uint64_t ticks) const {
        const bool complete = compared_ == ticks && (problem_.empty() || ticks == 0);
        if (differs_at_)
            printResult("  its stored samples differ from tick {}\n", *differs_at_);
        else if (complete)
            printResult("  {} stored samples, each as recomputed\n", compared_);
        if (!complete)
            printResult("  samples.bin: {}{} of {} samples could be compared\n", problem_, compared_, ticks);
        return !differs_at_ && (complete || (may_be_missing_ > 0 && ticks - compared_ <= may_be_missing_));
    }

  private:
    std::uint64_t may_be_missing_;  // samples not yet on the disk when the attempt was cut short
    records::Samples stored_;
    std::string problem_;         // ends with ", "; empty: none
    std::uint64_t compared_ = 0;  // number of stored samples
    std::optional<std::uint64_t> differs_at_;
};

// The part of a result that a replay of the same inputs with the same score table must give again, as text.
std::string reproducibleText(const records::AttemptResult& result, std::vector<records::EventRow> events) {
    std::erase_if(events, [](const records::EventRow& event) { return event.kind != "critical"; });
    const auto number = [](double v) { return std::isnan(v) ? "none" : fmt::format("{:.6f}", v); };
    std::string text = fmt::format("{} {}", result.target_hit, number(result.total));
    for (const records::MetricRow& row : result.metrics)
        text += fmt::format(", {} {} {} of {}", row.id, number(row.value), number(row.points),
                            number(row.max_points));
    for (const std::string& step : result.steps.done)
        text += ", " + step;
    for (const records::EventRow& event : events)
        text += ", " + event.text;
    return text;
}

// Returns false, and prints why, if the recorded result differs from that of the recorded inputs, or cannot
// be compared: ticks were lost, or this program has another score table. A score that nobody can check may be
// a forged one.
bool reportResultAgain(const records::RecordInfo& recorded, const records::AttemptResult& today,
                       const std::vector<training::SessionEvent>& events) {
    if (recorded.lost) {
        printResult("  its score cannot be checked: the record ends before the attempt did\n");
        return false;
    }
    if (recorded.result->score_version != today.score_version) {
        printResult("  its score cannot be checked: score table {} is {} than this program's {}\n",
                    recorded.result->score_version,
                    recorded.result->score_version < today.score_version ? "older" : "newer",
                    today.score_version);
        if (recorded.result->target_hit != today.target_hit)
            printResult("  its target is NOT that of the recorded inputs\n");
        return false;
    }
    std::vector<records::EventRow> rows;
    for (const training::SessionEvent& event : events)
        rows.push_back({event.tick, event.kind, event.text});
    if (reproducibleText(*recorded.result, recorded.events) == reproducibleText(today, rows)) return true;
    printResult(
        "  the recorded result is NOT the result of the recorded inputs: record.json was altered, or "
        "was written by another program version ({})\n",
        recorded.program_version);
    return false;
}

void reportOutcome(const records::Record& record, const records::ReplayResult& result) {
    printResult("replayed {} ticks: state hash {}, {}\n", result.ticks, hexText(result.state_hash),
                result.equal() ? "as recorded" : "NOT as recorded");
    if (result.first_mismatch)
        printResult("  first difference within the {} ticks before tick {}\n", records::kFrameTicks,
                    result.first_mismatch->ticks);
    if (result.end_mismatch)
        printResult("  recorded: tick {}, state hash {}\n", record.info.end->tick,
                    hexText(record.info.end->state_hash));
}

// Prints the recorded score beside today's. A metric is printed if it earns other points today.
void reportScoreAgain(const records::AttemptResult& recorded, const records::AttemptResult& today) {
    printResult("score {:.1f} of 100 when recorded, with score table {}; {:.1f} with today's table {}\n",
                recorded.total, recorded.score_version, today.total, today.score_version);
    const auto points = [](const records::AttemptResult& result, const std::string& id) {
        for (const records::MetricRow& row : result.metrics)
            if (row.id == id) return fmt::format("{:.1f} of {:.3g}", row.points, row.max_points);
        return std::string("not in the table");
    };
    std::vector<records::MetricRow> rows = today.metrics;
    for (const records::MetricRow& row : recorded.metrics)
        if (std::none_of(rows.begin(), rows.end(), [&](const auto& known) { return known.id == row.id; }))
            rows.push_back(row);
    for (const records::MetricRow& row : rows)
        if (const std::string then = points(recorded, row.id), now = points(today, row.id); then != now)
            printResult("  {}: {} points when recorded, {} today\n", row.name, then, now);
}

// Converts the recorded poses to a trace of the replay device, which is placed beside the patient. Ticks
// without a new pose are left out, because a trace repeats its last pose.
haptics::Trace recordedHand(const records::Record& record, const Pose& patient_from_replayed) {
    const Pose& patient_from_recorded = record.header.settings.patient_from_device;
    const bool same = patient_from_recorded.position_m == patient_from_replayed.position_m &&
                      patient_from_recorded.rotation == patient_from_replayed.rotation;
    const Pose replayed_from_recorded = patient_from_replayed.inverse() * patient_from_recorded;
    haptics::Trace hand;
    for (std::size_t i = 0; i < record.inputs.size(); ++i) {
        const haptics::DeviceState& device = record.inputs[i].device;
        if (device.fresh == 0 && !hand.samples.empty()) continue;
        hand.samples.push_back(
            {std::llround(double(i) * record.header.settings.dt_s * 1e9),
             same ? device.device_from_stylus : replayed_from_recorded * device.device_from_stylus,
             device.buttons});
    }
    return hand;
}

using EachTick = std::function<void()>;

haptics::TouchMap cachedTouchMap(const patient::Patient& patient, const records::Record& record) {
    return loadOrMakeTouchMap(patient, record.header.package_digest, cacheFolder() / "derived");
}

// Recomputes the record through `session` and stores the frame states in `timeline`.
records::ReplayResult recompute(const patient::Patient& patient, const records::Record& record,
                                Session& session, Timeline* timeline, const EachTick& each = {}) {
    return records::replay(
        patient, record,
        [&](const haptics::TickInput& input, const haptics::TickOutput& output,
            const haptics::NeedleEvents& events) {
            session.update(input, output, events);
            if (timeline) timeline->add(output.tick, [&] { return session.frameState(output); });
            if (each) each();
        },
        [&](const patient::Patient& on) { return cachedTouchMap(on, record); });
}

Session makeSession(const patient::Patient& patient, const records::Record& record) {
    const records::RecordInfo& info = record.info;
    Session session(patient, info.path, info.capture_points, info.approach_distance_m, nullptr,
                    record.header.settings.dt_s);
    session.setInstruments(record.header.instruments);
    session.setCourse(recordedCourse(record.info));
    session.setCase(recordedCase(record.info));
    session.setAccess(record.header.settings.tools.access);
    return session;
}

void show(const ReplayOptions& options, const patient::Patient& patient, const records::Record& record,
          const Timeline& timeline, const std::vector<Capture>& captures) {
    std::optional<Timeline> ghost;
    if (!options.ghost.empty()) {
        const records::Record other = records::loadRecord(options.ghost);
        ghost.emplace(other.inputs.size());
        Session session = makeSession(patient, other);
        recompute(patient, other, session, &*ghost);
        if (ghost->empty()) ghost.reset();
    }
    const haptics::TouchMap touch = cachedTouchMap(patient, record);
    ShownReplay shown{patient, record.info.path, timeline};
    shown.ghost = ghost ? &*ghost : nullptr;
    shown.ticks = record.inputs.size();
    shown.press = {&touch, record.header.settings.tools, record.header.settings.dt_s};
    shown.window = options.window;
    shown.at_s = options.at_s;
    catchInterrupts();
    showReplay(shown, captures, options.out);
}

}  // namespace

int replay(const ReplayOptions& options) {
    requireFolder(options.out, "--out");
    const std::filesystem::path record_folder = records::recordFolder(options.record);
    const records::Record record = records::loadRecord(record_folder);
    StoredSamples stored(record_folder, !record.info.end);
    reportDamage(record);
    const records::RecordInfo& info = record.info;
    const std::filesystem::path folder = options.patient.empty() ? info.patient_folder : options.patient;
    const patient::Package package = patient::loadPackage(folder);
    const patient::Patient patient(package);
    if (!options.save_hand.empty())
        haptics::saveTrace(recordedHand(record, placeDeviceBeside(patient.grid())), options.save_hand);

    const std::optional<OtherSegmentation> other = loadOtherSegmentation(patient, options.full);
    std::optional<ForceComparison> truth;
    Session session = makeSession(patient, record);
    if (other) session.compareWith(truth.emplace(*other, record.header.settings.tools.needle));
    session.setWatcher([&](const haptics::TickOutput& now, const SessionLog& log) {
        stored.compare(records::makeSample(now, log.progress.clearance_m));
    });
    const haptics::Clock clock = monotonicClock();
    const std::int64_t start_ns = clock.now_ns(clock.context);
    const double dt_ns = record.header.settings.dt_s * 1e9;
    std::uint64_t played = 0;
    Timeline timeline(record.inputs.size());
    const records::ReplayResult result =
        recompute(patient, record, session, options.show ? &timeline : nullptr, [&] {
            ++played;
            if (!options.fast && !options.show)
                clock.sleepUntil_ns(clock.context, start_ns + std::llround(double(played) * dt_ns));
        });

    LoopTotals totals;
    totals.haptics.ticks = result.ticks;
    totals.elapsed_s = double(result.ticks) * record.header.settings.dt_s;
    const AttemptFacts facts{
        info.patient_name,           folder,  info.scenario, info.seed, "replay", info.path,
        record.header.settings.dt_s, "record"};
    records::RecordInfo replayed = info;
    replayed.device = "record", replayed.clock = "replay", replayed.firmware_sha256.clear();
    replayed.end = records::RecordEnd{result.ticks, result.state_hash};
    replayed.result = makeResult(patient, session.log(), totals, false);
    if (info.result) replayed.result->aborted = info.result->aborted;  // how it ended is no simulation input
    writeResults({patient, facts, replayed}, session.log(), totals, options.out);
    reportOutcome(record, result);
    if (info.result) reportScoreAgain(*info.result, *replayed.result);
    // With other ticks, the result differs for another reason.
    const bool same_result =
        !info.result || !result.equal() || reportResultAgain(info, *replayed.result, session.log().events);
    if (options.show && !timeline.empty()) show(options, patient, record, timeline, session.newCaptures());
    return stored.report(result.ticks) && result.equal() && same_result ? 0 : 1;
}

}  // namespace stylet::trainer
