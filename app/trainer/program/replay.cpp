#include "app/trainer/program/replay.h"

#include <cmath>
#include <cstdio>
#include <optional>

#include "app/records/replay.h"
#include "app/records/samples.h"
#include "app/trainer/attempt/hand.h"
#include "app/trainer/display/replay_show.h"
#include "app/trainer/program/results.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/hex.h"
#include "haptics/devices/replay.h"

namespace stylet::trainer {

namespace {

void reportDamage(const records::Record& record) {
    if (record.torn_bytes > 0)
        std::fprintf(stderr,
                     "stylet: the record is damaged: %llu bytes after its last complete frame were removed\n",
                     static_cast<unsigned long long>(record.torn_bytes));
    if (record.info.lost)
        std::fprintf(stderr, "stylet: ticks %llu to %llu were lost during recording; the record ends there\n",
                     static_cast<unsigned long long>(record.info.lost->first),
                     static_cast<unsigned long long>(record.info.lost->last));
    if (!record.info.end)
        std::fprintf(stderr, "stylet: the attempt was cut short; replaying the recorded part\n");
}

// Compares the stored samples of a trainee's attempt with the recomputed ones.
class StoredSamples {
  public:
    StoredSamples(const std::filesystem::path& folder, bool cut_short) {
        if (!std::filesystem::exists(folder / "samples.bin")) return;
        try {
            stored_ = records::loadSamples(folder);
        } catch (const DataError& e) {
            if (!cut_short) throw;  // else the kill may have left the header incomplete
            std::fprintf(stderr, "stylet: no stored samples to compare with: %s\n", e.what());
        }
    }
    void compare(const records::Sample& recomputed) {
        if (!stored_ || differs_at_ || next_ == stored_->samples.size()) return;
        if (recomputed.tick < stored_->samples[next_].tick) return;  // the sample of this tick was lost
        if (!records::sameInFile(recomputed, stored_->samples[next_])) differs_at_ = recomputed.tick;
        ++next_;
    }
    // Prints the result. Returns false if a sample differs.
    bool report() const {
        if (!stored_) return true;
        if (differs_at_)
            std::printf("  its stored samples differ from tick %llu\n",
                        static_cast<unsigned long long>(*differs_at_));
        else
            std::printf("  %zu stored samples, each as recomputed\n", next_);
        return !differs_at_;
    }

  private:
    std::optional<records::Samples> stored_;
    std::size_t next_ = 0;
    std::optional<std::uint64_t> differs_at_;
};

void reportOutcome(const records::Record& record, const records::ReplayResult& result) {
    std::printf("replayed %llu ticks: state hash %s, %s\n", static_cast<unsigned long long>(result.ticks),
                hexText(result.state_hash).c_str(), result.equal() ? "as recorded" : "NOT as recorded");
    if (result.differs_at)
        std::printf("  first difference within the %u ticks before tick %llu\n", records::kFrameTicks,
                    static_cast<unsigned long long>(result.differs_at->ticks));
    if (result.end_missed)
        std::printf("  recorded: tick %llu, state hash %s\n",
                    static_cast<unsigned long long>(record.info.end->tick),
                    hexText(record.info.end->state_hash).c_str());
}

// Converts the recorded poses to a trace of the replay device, which is beside the patient. Ticks without a
// new pose are left out, because a trace keeps the last pose.
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

records::Record recordIn(const std::filesystem::path& folder) {
    const bool whole = std::filesystem::exists(folder / "record" / "record.json");
    return records::loadRecord(whole ? folder / "record" : folder);
}

using EachTick = std::function<void()>;

// Recomputes the record through `session` and stores the frame states in `timeline`.
records::ReplayResult computeAgain(const patient::Patient& patient, const records::Record& record,
                                   Session& session, Timeline* timeline, const EachTick& each = {}) {
    return records::replay(patient, record,
                           [&](const haptics::TickInput& input, const haptics::TickOutput& output,
                               const haptics::NeedleEvents& events) {
                               session.take(input, output, events);
                               if (timeline)
                                   timeline->take(output.tick, [&] { return session.seen(output); });
                               if (each) each();
                           });
}

Session sessionOf(const patient::Patient& patient, const records::Record& record) {
    const records::RecordInfo& info = record.info;
    return Session(patient, info.path, info.moments, info.approach_distance_m, nullptr,
                   record.header.settings.dt_s);
}

void show(const ReplayOptions& options, const patient::Patient& patient, const records::Record& record,
          const Timeline& timeline, const std::vector<Moment>& moments) {
    std::optional<Timeline> ghost;
    if (!options.ghost.empty()) {
        const records::Record other = recordIn(options.ghost);
        ghost.emplace(other.inputs.size());
        Session session = sessionOf(patient, other);
        computeAgain(patient, other, session, &*ghost);
        if (ghost->empty()) ghost.reset();
    }
    const haptics::TouchMap touch =
        keptTouchMap(patient, record.header.package_digest, cacheFolder() / "derived");
    ShownReplay shown{patient, record.info.path, timeline};
    shown.ghost = ghost ? &*ghost : nullptr;
    shown.dt_s = record.header.settings.dt_s;
    shown.ticks = record.inputs.size();
    shown.touch = &touch;
    shown.guide = record.header.settings.tools.guide;
    shown.window = options.window;
    shown.at_s = options.at_s;
    catchInterrupts();
    showReplay(shown, moments, options.out);
}

}  // namespace

int replay(const ReplayOptions& options) {
    needFolder(options.out, "--out");
    const records::Record record = recordIn(options.record);
    const bool whole = std::filesystem::exists(options.record / "record" / "record.json");
    StoredSamples stored(whole ? options.record / "record" : options.record, !record.info.end);
    reportDamage(record);
    const records::RecordInfo& info = record.info;
    const std::filesystem::path folder = options.patient.empty() ? info.patient_folder : options.patient;
    const patient::Package package = patient::loadPackage(folder);
    const patient::Patient patient(package);
    if (!options.save_hand.empty())
        haptics::saveTrace(recordedHand(record, deviceBeside(patient.grid())), options.save_hand);

    const std::optional<OtherSegmentation> other = otherSegmentation(patient, options.full);
    std::optional<ForceTruth> truth;
    Session session = sessionOf(patient, record);
    if (other) session.compareWith(truth.emplace(*other, record.header.settings.tools.needle));
    session.setWatcher([&](const haptics::TickOutput& now, const SessionLog& log) {
        stored.compare(records::sampleOf(now, log.progress.clearance_m));
    });
    const haptics::Clock clock = monotonicClock();
    const std::int64_t start_ns = clock.now_ns(clock.context);
    const double dt_ns = record.header.settings.dt_s * 1e9;
    std::uint64_t played = 0;
    Timeline timeline(record.inputs.size());
    const records::ReplayResult result =
        computeAgain(patient, record, session, options.show ? &timeline : nullptr, [&] {
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
    writeResults(patient, facts, session.log(), totals, options.out);
    reportOutcome(record, result);
    if (options.show && !timeline.empty()) show(options, patient, record, timeline, session.newMoments());
    return stored.report() && result.equal() ? 0 : 1;
}

}  // namespace stylet::trainer
