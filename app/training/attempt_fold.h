// Everything that is hashed, in one place. An attempt is a fold over ticks of (package, scenario, what the
// device said and what was commanded in each tick); its state hash covers
//   haptics     tools, forces, output stage       haptics::Simulation, with
//   breathing   phase, holds, jitter              patient::BreathingState in it
//   the patient how he starts, coughs and sighs   patient::Interruption, the same
//   machines    C-arm, pedal, ultrasound knobs    machines.h
//   contrast    what became of every drop         patient::Contrast
//   dose        X-ray pulses, air kerma           dose.h
// and nothing else: no frame, no picture, no tool displacement. The last three begin with the first command
// that is for them; until then the hash is the simulation's own, and they cost nothing.
#pragma once

#include "app/training/dose.h"
#include "app/training/machines.h"
#include "haptics/haptics.h"
#include "patient/patient.h"

namespace stylet::training {

class AttemptFold {
  public:
    AttemptFold(const patient::Patient& patient, double dt_s)
        : contrast_(patient), dose_(DoseSettings{}, dt_s), dt_s_(dt_s) {}

    // Session thread, a replay, a test. The next tick, and the hash after it.
    std::uint64_t take(const haptics::TickInput&, const haptics::TickOutput&);

    bool begun() const noexcept { return begun_; }
    const Machines& machines() const noexcept { return machines_; }
    const patient::Contrast& contrast() const noexcept { return contrast_; }
    const DoseLedger& dose() const noexcept { return dose_.ledger(); }

  private:
    Machines machines_;
    patient::Contrast contrast_;
    Dose dose_;
    double dt_s_;
    bool begun_ = false;
    patient::StateHash commands_;  // for the machines, in order
};

}  // namespace stylet::training
