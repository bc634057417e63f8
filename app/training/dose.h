// What the patient was given: X-rays and contrast medium. A fold over ticks, hashed and scored.
#pragma once

#include <cstdint>

#include "app/training/machines.h"
#include "patient/patient.h"

namespace stylet::training {

struct DoseSettings {
    // At the reference point of IEC 60601-2-43, 150 mm from the isocentre toward the tube. 20 mGy/min at 15
    // pulses a second: abdominal fluoroscopy gives the skin 10 to 45 (Aroua et al. 2007, Eur. Radiol.
    // 17:1621). The tube's automatic exposure, which follows the patient's thickness, is not modelled.
    double air_kerma_per_pulse_gy = 22e-6;
    double source_to_detector_m = 1.1, source_to_isocentre_m = 0.72;  // model, section 8
    double reference_before_isocentre_m = 0.15;
};

// Percutaneous biliary procedures take 21.6 Gy cm^2 (median; Schmitz et al. 2019, Eur. Radiol. 29).
struct DoseLedger {
    double fluoroscopy_s = 0.0;  // pedal down
    std::uint64_t pulses = 0;
    double air_kerma_gy = 0.0;  // at the reference point
    double dose_area_gy_m2 = 0.0;
    double contrast_m3 = 0.0;  // injected, wherever it went
};

class Dose {
  public:
    Dose(const DoseSettings& settings, double dt_s) : settings_(settings), dt_s_(dt_s) {}
    // One tick, after its commands; counts the pulses into the machine's state too.
    void step(XrayState&, double injected_m3, std::uint64_t tick) noexcept;
    const DoseLedger& ledger() const noexcept { return ledger_; }
    void addTo(patient::StateHash&) const noexcept;

  private:
    DoseSettings settings_;
    double dt_s_;
    DoseLedger ledger_;
    std::uint64_t until_pulse_ = 0;  // ticks
};

}  // namespace stylet::training
