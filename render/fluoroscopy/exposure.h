// Automatic brightness control: computes the quanta of a picture and the dose of its pulse. It is stateless:
// no pulse depends on earlier ones. A dose ledger adds up the doses.
//
// At 70 keV a microgray of air kerma is 33,400 photons/mm2: 1 / (70 keV * 0.0267 cm2/g). The mass
// energy-absorption coefficient of air is interpolated between 0.03041 at 60 and 0.02407 at 80 keV (Hubbell
// and Seltzer, NIST, NISTIR 5632, 1995). The detector receives 20 to 100 nGy per pulse in fluoroscopy (AAPM
// report 125, 2012), and detects 65 % of the quanta (DQE of 0.5 mm of CsI: Granfors and Aufrichtig, Med.
// Phys. 27, 2000). In normal mode the limit at the skin is 88 mGy per minute (21 CFR 1020.32(e)).
#pragma once

#include <span>

#include "render/fluoroscopy/beam.h"

namespace stylet::render {

struct DoseSettings {
    double detector_kerma_gy = 40e-9;  // target per pulse, behind the patient, in the middle of the picture
    double max_kerma_gy_per_s = 1.4667e-3;  // free in air at the reference point: 88 mGy/min
    double min_kerma_gy_per_s = 5e-6;
    double max_kerma_gy_per_pulse = 60e-6;  // a tube at full current for 20 ms
};

inline constexpr double kPhotonsPerM2Gy = 3.34e16;
inline constexpr double kDetectedShare = 0.65;
// The patient entrance reference point: 15 cm from the isocentre toward the source (IEC 60601-2-43).
inline constexpr double kSourceToReference_m = kSourceToIsocentre_m - 0.150;

struct Exposure {
    double transmission = 1.0;        // of the metered field, geometric mean
    double quanta_per_pixel = 0.0;    // detected in an unattenuated pixel
    double reference_kerma_gy = 0.0;  // of this pulse, at the reference point
    double dose_area_gy_m2 = 0.0;     // of this pulse
    bool at_limit = false;            // the tube is at its limit: the picture is noisier
};

// Transmission from line integrals in the middle of the field. Ignores values < 0 (behind a blade) and below
// kMinTissuePath (beside the patient). Returns 1 if no value is left; the tube then emits its minimum.
double meteredTransmission(std::span<const float> metered);
inline constexpr float kMinTissuePath = 0.05f;

Exposure computeExposure(double transmission, const Collimation&, double side_m, int pixels,
                         double pulse_rate_hz, const DoseSettings&);

}  // namespace stylet::render
