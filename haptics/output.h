// The one output stage: every force a device gets has passed here, in this order (model, section 4):
// finite -> rate limit -> device gain, ramp and wall -> passivity -> final clamp -> send.
#pragma once

#include <cstdint>

#include "haptics/device.h"
#include "haptics/needle.h"
#include "haptics/passivity.h"
#include "haptics/safety.h"
#include "haptics/tool.h"

namespace stylet::haptics {

struct OutputSettings {
    double rate_limit_n_per_s = 2000.0;     // falls of a puncture pass within 1 ms; see haptics/README.md
    double model_force_n = 22.0;            // F_model: the largest force the model asks for (bone)
    double model_tangent_n_per_m = 4000.0;  // K_tangent: see worstTangent()
    // 0 only watches, for stress tests that show what the controller is for.
    double controller_share = 1.0;
};

// One tick, device frame.
struct OutputTick {
    ToolForce tool;
    Vec3 grip_m{0.0};         // what the device moves: the tip, where no clutch is between them
    double share = 1.0;       // of the model's force: the clutch's
    std::uint32_t unmet = 0;  // Fault bits of checkDevice()
};

struct OutputState {
    SafetyState safety;
    PassivityState passivity;
    Vec3 model_n{0.0};       // after the rate limit, before gain and device
    Vec3 grip_m{0.0};        // of the last tick
    double share = 1.0;      // of the last tick
    bool moved = false;      // there has been one
    Vec3 controller_n{0.0};  // the controller's part of what was sent
    Vec3 sent_n{0.0};
    bool limited = false;  // the last force was cut by a limit
};

// The steepest the model gets with a table, N/m: 2 k - a1 at a cut (Eq. 1), k on bone.
double worstTangent(const patient::TissueTable&, const NeedleSettings&) noexcept;

// s = min(1, K_dev / K_tangent, F_dev / F_model): steady within a session, written into the record.
double outputGain(const DeviceProfile&, const OutputSettings&) noexcept;

// Haptics thread. noexcept, no allocation. Returns what to send, device frame; zero within 20 ms of a fault.
Vec3 stepOutput(OutputState&, const OutputSettings&, const DeviceProfile&, double gain, const OutputTick&,
                double dt_s) noexcept STYLET_NONBLOCKING;
void hashOutput(patient::StateHash&, const OutputState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
