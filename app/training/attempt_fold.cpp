#include "app/training/attempt_fold.h"

#include <algorithm>
#include <array>
#include <span>

#include "base/hash.h"

namespace stylet::training {

namespace {

// Contrast medium flows through the needle, or through a drain in place.
patient::ContrastInput contrastInput(const haptics::TickOutput& output, double rate_m3_per_s) {
    const haptics::AccessOutput& access = output.access;
    if (access.drain != haptics::DrainState::in_place || access.path_count < 2)
        return {output.tip_reference_m, rate_m3_per_s, output.phase != haptics::Phase::outside};
    std::array<Vec3, haptics::kMaxPathPoints> path_m;
    const auto count = std::size_t(access.path_count);
    std::copy_n(access.path_m.begin(), count, path_m.begin());
    return {haptics::pointAt({std::span(path_m).first(count), access.drain_m}, access.drain_m), rate_m3_per_s,
            true};
}

}  // namespace

std::uint64_t AttemptFold::step(const haptics::TickInput& input, const haptics::TickOutput& output) {
    for (std::uint32_t i = 0; i < input.command_count; ++i) {
        const haptics::Command& command = input.commands[i];
        if (!isEquipmentCommand(command)) continue;
        begun_ = true;
        training::applyCommand(equipment_, command);
        commands_.add(std::uint64_t(command.kind) | std::uint64_t(command.value) << 32);
    }
    if (!begun_) return output.state_hash;
    contrast_.step(contrastInput(output, equipment_.injected_m3_per_s), dt_s_);
    dose_.step(equipment_.xray, contrast_.volumes().injected_m3, output.tick);
    StateHash hash;
    hash.add(output.state_hash);
    hash.add(commands_.value());
    hash.add(contrast_.hash());
    dose_.addTo(hash);
    return hash.value();
}

}  // namespace stylet::training
