// X-ray, contrast medium and local anaesthetic dose of the patient. It is updated every tick, hashed and
// scored.
#pragma once

#include <cstdint>

#include "app/training/equipment.h"
#include "base/hash.h"
#include "patient/patient.h"

namespace stylet::training {

struct DoseSettings {
    // At the reference point of IEC 60601-2-43, 150 mm from the isocentre toward the tube. The default gives
    // 20 mGy/min at 15 pulses per second. Abdominal fluoroscopy delivers 10 to 45 mGy/min to the skin (Aroua
    // et al. 2007, Eur. Radiol. 17:1621). A real tube's automatic exposure control, which adapts the dose to
    // the patient's thickness, is not modelled.
    double air_kerma_per_pulse_gy = 22e-6;
    double source_to_detector_m = 1.1, source_to_isocentre_m = 0.72;  // model, section 8
    double reference_before_isocentre_m = 0.15;
};

// For comparison: the median dose-area product of percutaneous biliary procedures is 21.6 Gy cm^2 (Schmitz
// et al. 2019, Eur. Radiol. 29).
struct DoseLedger {
    double fluoroscopy_s = 0.0;  // time with the pedal down
    std::uint64_t pulses = 0;
    double air_kerma_gy = 0.0;  // at the reference point
    double dose_area_gy_m2 = 0.0;
    double contrast_m3 = 0.0;     // total injected
    double anaesthetic_m3 = 0.0;  // total injected; set by the fold, hashed with its depots
};

class Dose {
  public:
    Dose(const DoseSettings& settings, double dt_s) : settings_(settings), dt_s_(dt_s) {}
    // Call once per tick, after its commands. Also updates the pulse count in the C-arm's state.
    void step(XrayState&, double injected_m3, std::uint64_t tick) noexcept;
    void setAnaesthetic(double injected_m3) noexcept { ledger_.anaesthetic_m3 = injected_m3; }
    const DoseLedger& ledger() const noexcept { return ledger_; }
    void addTo(StateHash&) const noexcept;

  private:
    DoseSettings settings_;
    double dt_s_;
    DoseLedger ledger_;
    std::uint64_t until_pulse_ = 0;  // ticks
};

}  // namespace stylet::training
