#include "app/training/dose.h"
#include "base/hash.h"

#include <algorithm>
#include <cmath>

namespace stylet::training {

void Dose::step(XrayState& xray, double injected_m3, std::uint64_t tick) noexcept {
    ledger_.contrast_m3 = injected_m3;
    if (until_pulse_ > 0) --until_pulse_;  // also while the pedal is up, so tapping gives no extra pulses
    if (!xray.pedal) return;
    ledger_.fluoroscopy_s += dt_s_;
    const auto period = std::uint64_t(std::max(1.0, std::floor(1.0 / (xray.pulses_per_s * dt_s_) + 0.5)));
    until_pulse_ = std::min(until_pulse_, period);
    if (until_pulse_ == 0) {
        const double scale = (settings_.source_to_isocentre_m - settings_.reference_before_isocentre_m) /
                             settings_.source_to_detector_m;
        const double edge_m = xray.field_m * scale;
        ++ledger_.pulses;
        ledger_.air_kerma_gy += settings_.air_kerma_per_pulse_gy;
        ledger_.dose_area_gy_m2 += settings_.air_kerma_per_pulse_gy * edge_m * edge_m;
        xray.pulses = ledger_.pulses;
        xray.last_pulse_tick = tick;
        until_pulse_ = period;
    }
}

void Dose::addTo(StateHash& hash) const noexcept {
    hash.add(ledger_.pulses);
    for (const double part :
         {ledger_.fluoroscopy_s, ledger_.air_kerma_gy, ledger_.dose_area_gy_m2, ledger_.contrast_m3})
        hash.add(part);
}

}  // namespace stylet::training
