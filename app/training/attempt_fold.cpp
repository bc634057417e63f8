#include "app/training/attempt_fold.h"
#include "base/hash.h"

namespace stylet::training {

std::uint64_t AttemptFold::step(const haptics::TickInput& input, const haptics::TickOutput& output) {
    for (std::uint32_t i = 0; i < input.command_count; ++i) {
        const haptics::Command& command = input.commands[i];
        if (!isEquipmentCommand(command)) continue;
        begun_ = true;
        training::applyCommand(equipment_, command);
        commands_.add(std::uint64_t(command.kind) | std::uint64_t(command.value) << 32);
    }
    if (!begun_) return output.state_hash;
    contrast_.step(
        {output.tip_reference_m, equipment_.injected_m3_per_s, output.phase != haptics::Phase::outside},
        dt_s_);
    dose_.step(equipment_.xray, contrast_.volumes().injected_m3, output.tick);
    StateHash hash;
    hash.add(output.state_hash);
    hash.add(commands_.value());
    hash.add(contrast_.hash());
    dose_.addTo(hash);
    return hash.value();
}

}  // namespace stylet::training
