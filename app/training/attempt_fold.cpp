#include "app/training/attempt_fold.h"

#include "app/training/drain_end.h"
#include "base/hash.h"

namespace stylet::training {

namespace {

constexpr double kAxisStep_m = 0.002;

}  // namespace

Drawn drawnAt(const haptics::TickOutput& output) noexcept {
    if (output.phase == haptics::Phase::outside) return output.access.open ? Drawn::nothing : Drawn::air;
    if (output.access.wire_in) return Drawn::nothing;  // the wire fills the needle
    if (output.tissue == patient::Tissue::duct) return Drawn::bile;
    return output.tissue == patient::Tissue::vessel ? Drawn::blood : Drawn::nothing;
}

// Contrast medium flows through the needle, or through a drain in place: where the drain's axis lies in a
// duct, as near to its tip as possible; else out of the hole nearest to the tip that opens on its surface;
// else out of the tip. The axis comes first so that records made before the surface counted replay to the
// same hash.
patient::ContrastInput AttemptFold::contrastInput(const haptics::TickOutput& output) const {
    const double rate_m3_per_s = equipment_.injected_m3_per_s;
    const haptics::AccessOutput& access = output.access;
    if (access.drain != haptics::DrainState::in_place || access.path_count < 2)
        return {output.tip_reference_m, rate_m3_per_s, output.phase != haptics::Phase::outside};
    const DrainEnd end(access);
    for (double back_m = 0.0; back_m <= haptics::kSideHoles_m; back_m += kAxisStep_m)
        if (isDuctTissue(*patient_, end.at(back_m))) return {end.at(back_m), rate_m3_per_s, true};
    for (int hole = 0; hole < DrainEnd::kHoles; ++hole)
        if (const auto opening_m = end.opening(*patient_, hole, drain_radius_m_))
            return {*opening_m, rate_m3_per_s, true};
    return {end.at(0.0), rate_m3_per_s, true};
}

patient::AnaestheticInput AttemptFold::anaestheticInput(const haptics::TickOutput& output) const noexcept {
    using patient::Tissue;
    const bool inside = output.phase != haptics::Phase::outside && !output.access.open;
    const bool at_skin = output.tissue == Tissue::air && output.depth_m <= kGasDepth_m;
    return {output.tip_reference_m, equipment_.anaesthetic_m3_per_s,
            !inside   ? Tissue::air
            : at_skin ? Tissue::skin
                      : output.tissue};
}

std::uint64_t AttemptFold::step(const haptics::TickInput& input, const haptics::TickOutput& output) {
    for (std::uint32_t i = 0; i < input.command_count; ++i) {
        const haptics::Command& command = input.commands[i];
        if (command.kind == haptics::CommandKind::answer && answers_.count < 32) {
            if (command.value != 0) answers_.yes |= 1u << answers_.count;
            ++answers_.count;
        }
        if (!isEquipmentCommand(command)) continue;
        begun_ = true;
        training::applyCommand(equipment_, command);
        const bool pressed = command.kind == haptics::CommandKind::pedal && command.value != 0;
        if (pressed && output.phase != haptics::Phase::outside)
            equipment_.xray.aimed_m = output.patient_from_needle.position_m;
        if (command.kind == haptics::CommandKind::aspirate)
            aspiration_ = {aspiration_.count + 1, output.tick, drawnAt(output)};
        commands_.add(std::uint64_t(command.kind) | std::uint64_t(command.value) << 32);
    }
    if (equipment_.anaesthetic_m3_per_s > 0.0 || equipment_.injected_m3_per_s > 0.0)
        injection_ = {output.tick, equipment_.anaesthetic_m3_per_s > 0.0};
    const std::uint64_t hash = begun_ ? stepEquipment(output) : output.state_hash;
    if (answers_.count == 0) return hash;
    StateHash with_answers;
    with_answers.add(hash);
    with_answers.add(std::uint64_t(answers_.yes) << 32 | answers_.count);
    return with_answers.value();
}

std::uint64_t AttemptFold::stepEquipment(const haptics::TickOutput& output) {
    contrast_.step(contrastInput(output), dt_s_);
    anaesthetic_.step(anaestheticInput(output), dt_s_);
    dose_.step(equipment_.xray, contrast_.volumes().injected_m3, output.tick);
    dose_.setAnaesthetic(anaesthetic_.volumes().injected_m3);
    StateHash hash;
    hash.add(output.state_hash);
    hash.add(commands_.value());
    hash.add(contrast_.hash());
    dose_.addTo(hash);
    if (anaesthetic_.begun()) hash.add(anaesthetic_.hash());
    return hash.value();
}

}  // namespace stylet::training
