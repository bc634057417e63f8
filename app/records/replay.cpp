#include "app/records/replay.h"

#include <fmt/core.h>

#include "app/training/attempt_fold.h"
#include "base/hex.h"

namespace stylet::records {

namespace {

// The map that finger, probe and scalpel press on, if the record uses one of these tools.
std::optional<haptics::TouchMap> touchMapFor(const patient::Patient& patient, const Record& record,
                                             const MakeTouch& make) {
    bool presses = haptics::pressesOnSkin(record.header.settings.tools.first);
    for (const haptics::TickInput& input : record.inputs)
        for (std::uint32_t i = 0; i < input.command_count; ++i)
            presses = presses || haptics::selectsSkinTool(input.commands[i]);
    if (!presses) return std::nullopt;
    return make ? make(patient) : haptics::makeTouchMap(patient);
}

// The lumen that the guide wire follows, if the record uses the wire.
std::optional<patient::DuctSpace> ductSpaceFor(const patient::Patient& patient, const Record& record) {
    bool uses = false;
    for (const haptics::TickInput& input : record.inputs)
        for (const haptics::Command& command : input.validCommands())
            uses = uses || haptics::selectsAccessTool(command);
    if (!uses) return std::nullopt;
    return patient::makeDuctSpace(patient);
}

}  // namespace

ReplayResult replay(const patient::Patient& patient, const Record& record, const TickCallback& each,
                    const MakeTouch& make_touch) {
    const std::uint64_t digest = patient::digest(patient.package());
    if (digest != record.header.package_digest)
        throw DataError(record.info.patient_folder, "digest",
                        fmt::format("this patient is {}, the record was made on {}", hexText(digest),
                                    hexText(record.header.package_digest)));
    const std::optional<haptics::TouchMap> touch = touchMapFor(patient, record, make_touch);
    const std::optional<patient::DuctSpace> ducts = ductSpaceFor(patient, record);
    haptics::Simulation simulation(patient, record.header.settings, touch ? &*touch : nullptr,
                                   ducts ? &*ducts : nullptr);
    training::AttemptFold fold(patient, record.header.settings.dt_s);
    fold.setDrain(record.header.settings.tools.access.drain);
    ReplayResult result;
    haptics::TickOutput output;
    haptics::NeedleEvents events;
    auto checkpoint = record.checkpoints.begin();
    for (const haptics::TickInput& input : record.inputs) {
        simulation.step(input, output, events);
        result.state_hash = fold.step(input, output);
        ++result.ticks;
        if (each) each(input, output, events);
        if (checkpoint == record.checkpoints.end() || checkpoint->ticks != result.ticks) continue;
        if (!result.first_mismatch && checkpoint->state_hash != result.state_hash)
            result.first_mismatch = *checkpoint;
        ++checkpoint;
    }
    result.end_mismatch = record.info.end && (record.info.end->tick != output.tick ||
                                              record.info.end->state_hash != result.state_hash);
    return result;
}

}  // namespace stylet::records
