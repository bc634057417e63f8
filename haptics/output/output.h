// The only output stage. Every force sent to a device passes through it, in this order (model, section 4):
// finite -> rate limit -> device gain, ramp and wall -> passivity -> final clamp -> send. The bound by the
// stored energy runs before it (stored_energy.h, called by loop/simulation.cpp).
#pragma once

#include <cstdint>

#include "base/hash.h"
#include "haptics/output/passivity.h"
#include "haptics/output/safety.h"
#include "haptics/tools/device.h"
#include "haptics/tools/needle.h"
#include "haptics/tools/tool.h"

namespace stylet::haptics {

struct OutputSettings {
    // The force drop of a puncture passes within 1 ms; see haptics/README.md.
    double rate_limit_n_per_s = 2000.0;
    double model_force_n = 22.0;            // F_model: largest force of the model (bone)
    double model_tangent_n_per_m = 4000.0;  // K_tangent: see maxTangent()
    // Share of the passivity controller's force that is applied. 0 disables it and the bound by the stored
    // energy, for stress tests that show their effect.
    double controller_share = 1.0;
};

// Input of one tick, device frame.
struct OutputTick {
    ToolForce tool;
    Vec3 grip_m{0.0};              // position of the grip; equals the tip unless there is a clutch
    double share = 1.0;            // fraction of the model's force left by the clutch
    std::uint32_t fault_bits = 0;  // Fault bits of checkDevice()
};

struct OutputState {
    SafetyState safety;
    PassivityState passivity;
    Vec3 model_n{0.0};       // after the rate limit, before gain and device
    Vec3 grip_m{0.0};        // of the last tick
    double share = 1.0;      // of the last tick
    bool moved = false;      // there has been a tick
    Vec3 controller_n{0.0};  // the controller's part of the force sent
    Vec3 sent_n{0.0};
    bool limited = false;  // the last force was reduced by a limit
};

// Largest tangent stiffness of the model with this table, N/m: 2 k - a1 at a puncture (Eq. 1), k on bone.
double maxTangent(const patient::TissueTable&, const NeedleSettings&) noexcept;

// s = min(1, K_dev / K_tangent, F_dev / F_model). Constant within a session and written into the record.
double outputGain(const DeviceProfile&, const OutputSettings&) noexcept;

// Haptics thread. noexcept, no allocation. Returns the force to send, device frame. It is zero within 20 ms
// after a fault.
Vec3 stepOutput(OutputState&, const OutputSettings&, const DeviceProfile&, double gain, const OutputTick&,
                double dt_s) noexcept STYLET_NONBLOCKING;
void hashOutput(StateHash&, const OutputState&) noexcept STYLET_NONBLOCKING;

}  // namespace stylet::haptics
