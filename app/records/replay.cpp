#include "app/records/replay.h"

#include "app/training/attempt_fold.h"
#include "base/hex.h"

namespace stylet::records {

namespace {

// The map that finger, probe and scalpel press on, if the record uses one of these tools.
std::optional<haptics::TouchMap> touchMapFor(const patient::Patient& patient, const Record& record) {
    bool presses = haptics::pressesOnSkin(record.header.settings.tools.first);
    for (const haptics::TickInput& input : record.inputs)
        for (std::uint32_t i = 0; i < input.command_count; ++i)
            presses = presses || haptics::takesToolOnSkin(input.commands[i]);
    if (!presses) return std::nullopt;
    return haptics::makeTouchMap(patient);
}

}  // namespace

ReplayResult replay(const patient::Patient& patient, const Record& record, const EachTick& each) {
    const std::uint64_t digest = patient::digest(patient.package());
    if (digest != record.header.package_digest)
        throw DataError(record.info.patient_folder, "digest",
                        "this patient is " + hexText(digest) + ", the record was made on " +
                            hexText(record.header.package_digest));
    const std::optional<haptics::TouchMap> touch = touchMapFor(patient, record);
    haptics::Simulation simulation(patient, record.header.settings, touch ? &*touch : nullptr);
    training::AttemptFold fold(patient, record.header.settings.dt_s);
    ReplayResult result;
    haptics::TickOutput output;
    haptics::NeedleEvents events;
    auto checkpoint = record.checkpoints.begin();
    for (const haptics::TickInput& input : record.inputs) {
        simulation.step(input, output, events);
        result.state_hash = fold.take(input, output);
        ++result.ticks;
        if (each) each(input, output, events);
        if (checkpoint == record.checkpoints.end() || checkpoint->ticks != result.ticks) continue;
        if (!result.differs_at && checkpoint->state_hash != result.state_hash)
            result.differs_at = *checkpoint;
        ++checkpoint;
    }
    result.end_missed = record.info.end && (record.info.end->tick != output.tick ||
                                            record.info.end->state_hash != result.state_hash);
    return result;
}

}  // namespace stylet::records
