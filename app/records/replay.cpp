#include "app/records/replay.h"

namespace stylet::records {

ReplayResult replay(const patient::Patient& patient, const Record& record, const EachTick& each) {
    const std::uint64_t digest = patient::digest(patient.package());
    if (digest != record.header.package_digest)
        throw patient::DataError(record.info.patient_folder, "digest",
                                 "this patient is " + hexOf(digest) + ", the record was made on " +
                                     hexOf(record.header.package_digest));
    haptics::Simulation simulation(patient, record.header.settings);
    ReplayResult result;
    haptics::TickOutput output;
    haptics::NeedleEvents events;
    auto checkpoint = record.checkpoints.begin();
    for (const haptics::TickInput& input : record.inputs) {
        simulation.step(input, output, events);
        ++result.ticks;
        if (each) each(input, output, events);
        if (checkpoint == record.checkpoints.end() || checkpoint->ticks != result.ticks) continue;
        if (!result.differs_at && checkpoint->state_hash != output.state_hash)
            result.differs_at = *checkpoint;
        ++checkpoint;
    }
    result.state_hash = output.state_hash;
    result.end_missed = record.info.end && (record.info.end->tick != output.tick ||
                                            record.info.end->state_hash != output.state_hash);
    return result;
}

}  // namespace stylet::records
