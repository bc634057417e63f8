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

// Compares the stored samples of a trainee's attempt with the recomputed ones.
class StoredSamples {
  public:
    StoredSamples(const std::filesystem::path& folder, bool cut_short) {
        if (!std::filesystem::exists(folder / "samples.bin")) return;
        try {
            stored_ = records::loadSamples(folder);
        } catch (const DataError& e) {
            if (!cut_short) throw;  // the header may be incomplete because the program was killed
            printMessage(fmt::format("no stored samples to compare with: {}", e.what()));
        }
    }
    void compare(const records::Sample& recomputed) {
        if (!stored_ || differs_at_ || next_ == stored_->samples.size()) return;
        if (recomputed.tick < stored_->samples[next_].tick) return;  // the sample of this tick was lost
        if (!records::equalWhenEncoded(recomputed, stored_->samples[next_])) differs_at_ = recomputed.tick;
        ++next_;
    }
    // Prints the result. Returns false if a sample differs.
    bool report() const {
        if (!stored_) return true;
        if (differs_at_)
            printResult("  its stored samples differ from tick {}\n", *differs_at_);
        else
            printResult("  {} stored samples, each as recomputed\n", next_);
        return !differs_at_;
    }

  private:
    std::optional<records::Samples> stored_;
    std::size_t next_ = 0;
    std::optional<std::uint64_t> differs_at_;
};

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
    if (options.show && !timeline.empty()) show(options, patient, record, timeline, session.newCaptures());
    return stored.report() && result.equal() ? 0 : 1;
}

}  // namespace stylet::trainer
