// The one output stage: every force a device gets has passed here, in this order:
// finite -> rate limit -> device gain and limits -> final clamp -> send.
#pragma once

#include <cstdint>

#include "haptics/device.h"
#include "haptics/needle.h"

namespace stylet::haptics {

struct OutputSettings {
    double rate_limit_n_per_s = 2000.0;     // falls of a puncture pass within 1 ms; see haptics/README.md
    double model_force_n = 22.0;            // F_model: the largest force the model asks for (bone)
    double model_tangent_n_per_m = 4000.0;  // K_tangent: see worstTangent()
};

// Fault bits; a set bit stays until the run is re-armed.
enum Fault : std::uint32_t {
    kFaultNotFinite = 1u << 0,   // a pose or force was NaN or infinite: zero was sent
    kFaultStaleInput = 1u << 1,  // the device gave nothing new for 20 ms
    kFaultRingFull = 1u << 2,    // a ring to the session was full: something was not recorded
};

struct OutputState {
    Vec3 model_n{0.0};  // after the rate limit, before gain and device
    Vec3 sent_n{0.0};
    std::uint32_t faults = 0;
    bool limited = false;  // the last force was cut by a limit
};

// The faults that take the force away. kFaultRingFull is not among them: it is the loop's, outside the state.
inline constexpr std::uint32_t kFaultsZeroForce = kFaultNotFinite | kFaultStaleInput;

// The steepest the model gets with a table, N/m: 2 k - a1 at a cut (Eq. 1), k on bone.
double worstTangent(const patient::TissueTable&, const NeedleSettings&) noexcept;

// s = min(1, K_dev / K_tangent, F_dev / F_model): steady within a session, written into the record.
double outputGain(const DeviceProfile&, const OutputSettings&) noexcept;

// Haptics thread. noexcept, no allocation. Returns what to send, in the frame of `force_n`. While a fault
// stands the force runs to zero at the rate limit.
Vec3 stepOutput(OutputState&, const OutputSettings&, const DeviceProfile&, double gain, const Vec3& force_n,
                double dt_s) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
