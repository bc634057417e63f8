// Computes the state hash of an attempt, tick by tick. Package, scenario, device states and commands
// determine an attempt, so a replay must give the same hash. The hash covers exactly the following:
//   haptics: tools, forces, output stage (haptics::Simulation), including
//     breathing: phase, breath-holds, jitter (patient::BreathingState)
//     interruptions: starts, coughs and sighs of the patient (patient::Interruption)
//   equipment: C-arm, pedal, ultrasound knobs (equipment.h)
//   contrast: the distribution of the medium (patient::Contrast)
//   local anaesthetic: its depots (patient::Anaesthetic), from the first injection on
//   dose: X-ray pulses, air kerma (dose.h)
// Rendered frames, pictures and the drawn displacement of tissue by a tool are not hashed. Equipment,
// contrast and dose are computed and hashed only from the first equipment command on. Before that, the hash
// equals the simulation's hash.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "app/training/dose.h"
#include "app/training/equipment.h"
#include "base/hash.h"
#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::training {

// What a syringe at the needle drew.
enum class Drawn : std::uint8_t { nothing, air, bile, blood };
inline constexpr std::array<std::string_view, 4> kDrawnNames{"nothing", "air", "bile", "blood"};
// What a syringe draws at this tick: nothing without a free needle in the body.
Drawn drawnAt(const haptics::TickOutput&) noexcept;
// Air closer to the skin than this is a voxel artefact at a slanted surface.
inline constexpr double kGasDepth_m = 0.005;
struct Aspiration {
    std::uint64_t count = 0;  // of draws so far
    std::uint64_t tick = 0;   // of the newest
    Drawn drawn = Drawn::nothing;
};
// The newest tick in which a syringe injected, and what.
struct Injection {
    std::uint64_t tick = 0;
    bool anaesthetic = false;  // else contrast medium
};
// Answers so far to the questions about the case, in the order in which they came.
struct Answers {
    std::uint32_t count = 0;
    std::uint32_t yes = 0;  // bit per answer, of the first 32
};

class AttemptFold {
  public:
    AttemptFold(const patient::Patient& patient, double dt_s)
        : patient_(&patient), contrast_(patient), dose_(DoseSettings{}, dt_s), dt_s_(dt_s) {}

    // Call before the first tick; default: kDrainDefaults.
    void setDrain(const haptics::TubeSettings& drain) noexcept { drain_radius_m_ = 0.5 * drain.outer_m; }

    // Session thread, a replay or a test. Adds the next tick and returns the hash after it.
    std::uint64_t step(const haptics::TickInput&, const haptics::TickOutput&);

    bool begun() const noexcept { return begun_; }
    const Equipment& equipment() const noexcept { return equipment_; }
    const patient::Contrast& contrast() const noexcept { return contrast_; }
    const patient::Anaesthetic& anaesthetic() const noexcept { return anaesthetic_; }
    const DoseLedger& dose() const noexcept { return dose_.ledger(); }
    const Aspiration& aspiration() const noexcept { return aspiration_; }
    const Answers& answers() const noexcept { return answers_; }
    const std::optional<Injection>& injection() const noexcept { return injection_; }

  private:
    std::uint64_t stepEquipment(const haptics::TickOutput&);
    patient::ContrastInput contrastInput(const haptics::TickOutput&) const;
    patient::AnaestheticInput anaestheticInput(const haptics::TickOutput&) const noexcept;

    const patient::Patient* patient_;
    Equipment equipment_;
    patient::Contrast contrast_;
    patient::Anaesthetic anaesthetic_;
    Dose dose_;
    double dt_s_;
    double drain_radius_m_ = 0.5 * haptics::kDrainDefaults.outer_m;
    bool begun_ = false;
    Aspiration aspiration_;
    std::optional<Injection> injection_;
    Answers answers_;
    StateHash commands_;  // hash of the equipment commands, in order
};

}  // namespace stylet::training
