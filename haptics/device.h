// A haptic device as the loop sees it: what it can do, what it says, what it is told. Drivers are in
// devices/.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "haptics/realtime.h"
#include "patient/geometry.h"

namespace stylet::haptics {

using patient::Pose;
using patient::Quat;
using patient::Vec3;

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// What is unknown is taken to be that of the weakest device we know (3D Systems' data sheet of the Touch).
inline constexpr double kWeakestForce_n = 3.3, kWeakestStiffness_n_per_m = 400.0, kLightestMass_kg = 0.045;
inline double knownOr(double value, double otherwise) noexcept {
    return std::isnan(value) ? otherwise : value;
}

inline bool isFinite(const Vec3& v) noexcept {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// The capability record. Every figure is cited in `source` or unknown (NaN, never a guess).
struct DeviceProfile {
    const char* name = "paper";
    double force_peak_n = 22.0;
    double stiffness_n_per_m = 1000.0;  // recommended, K_dev
    const char* source = "Mastmeyer et al. 2017: Phantom Premium class, 22 N";

    int force_axes = 3;  // 0: input only
    int torque_axes = 0;
    bool senses_rotation = true;
    bool has_dead_man = false;     // says in its flags whether a hand holds it
    bool force_calibrated = true;  // newtons on the bus are newtons at the grip
    double force_continuous_n = kUnknown;
    double rate_hz = 1000.0;
    // The bare mechanism: stability (model, section 4) is judged by these, never by a rendered damping.
    double mass_kg = kUnknown;
    double damping_n_s_per_m = kUnknown;  // physical
    double friction_n = kUnknown;         // Coulomb
    double resolution_m = kUnknown;       // of its encoders, at the tip
    // From send() to the motion it causes being read, beyond the loop's own tick: bus, driver, filters.
    double delay_s = 0.0;
    // Where the tip can go: a ball in the device frame.
    Vec3 workspace_centre_m{0.0};
    double workspace_radius_m = kUnknown;
};

// DeviceState::flags. Force flows only while every bit the loop needs is set (output.h).
enum DeviceFlag : std::uint32_t {
    kDeviceReady = 1u << 0,   // connected, homed, calibrated, motors on
    kDeviceHandOn = 1u << 1,  // the dead-man is held, or the device has none
    kDeviceClutch = 1u << 2,  // never needed: the tip is not where the grip is, see DeviceState
};

// The device as read in one tick.
struct DeviceState {
    Pose device_from_stylus;  // needle tool: stylus = needle frame (tip at origin, +z to the hub)
    std::uint32_t buttons = 0;
    std::uint32_t fresh = 1;  // 0: nothing new since the last read
    std::uint32_t flags = kDeviceReady | kDeviceHandOn;
    // With kDeviceClutch only. Workspace and wall are the grip's, and so is the work that a force does.
    Vec3 grip_at_m{0.0};       // device frame
    double force_share = 1.0;  // of the model's force: 0 while the clutch is held

    Vec3 grip_m() const noexcept {
        return (flags & kDeviceClutch) != 0 ? grip_at_m : device_from_stylus.position_m;
    }
    double share() const noexcept { return (flags & kDeviceClutch) != 0 ? force_share : 1.0; }
};

class HapticDevice {
  public:
    virtual ~HapticDevice() = default;
    virtual const DeviceProfile& profile() const noexcept = 0;
    // Haptics thread. The newest state; `now_ns` is the loop's time.
    virtual DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING = 0;
    // Haptics thread. Force in the device frame, N. Called from the output stage's one call site.
    virtual void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING = 0;
};

}  // namespace stylet::haptics
