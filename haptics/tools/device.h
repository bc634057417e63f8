// A haptic device as the loop sees it: capabilities, state, force command. Drivers are in devices/.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "base/geometry.h"
#include "base/realtime.h"

namespace stylet::haptics {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// Defaults for unknown values: those of the weakest device we know (3D Systems' data sheet of the Touch).
inline constexpr double kWeakestForce_n = 3.3, kWeakestStiffness_n_per_m = 400.0, kLightestMass_kg = 0.045;
inline double valueOrDefault(double value, double otherwise) noexcept {
    return std::isnan(value) ? otherwise : value;
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
    bool has_dead_man = false;     // its flags report whether a hand holds it
    bool force_calibrated = true;  // a commanded newton is a newton at the grip
    double force_continuous_n = kUnknown;
    double rate_hz = 1000.0;
    // The bare mechanism. Stability (model, section 4) is judged by these values, never by rendered damping.
    double mass_kg = kUnknown;
    double damping_n_s_per_m = kUnknown;  // physical
    double friction_n = kUnknown;         // Coulomb
    double resolution_m = kUnknown;       // of its encoders, at the tip
    // Delay from send() until the resulting motion is read, in addition to the loop's own tick: bus, driver
    // and filters.
    double delay_s = 0.0;
    // Reachable positions of the tip: a sphere in the device frame.
    Vec3 workspace_centre_m{0.0};
    double workspace_radius_m = kUnknown;
};

// The profile of a device that produces no force. Both texts must outlive the profile.
inline DeviceProfile inputOnlyProfile(const char* name, const char* source) noexcept {
    return {.name = name,
            .force_peak_n = 0.0,
            .stiffness_n_per_m = 0.0,
            .source = source,
            .force_axes = 0,
            .force_continuous_n = 0.0};
}

// True for a device that never exerts a force, such as a mouse or a controller.
inline bool isInputOnly(const DeviceProfile& profile) noexcept {
    return profile.force_axes == 0 || profile.force_peak_n == 0.0;
}

// Bits of DeviceState::flags. Force is sent only while kDeviceReady and kDeviceHandOn are set (safety.h).
enum DeviceFlag : std::uint32_t {
    kDeviceReady = 1u << 0,   // connected, homed, calibrated, motors on
    kDeviceHandOn = 1u << 1,  // the dead-man switch is held, or the device has none
    kDeviceClutch = 1u << 2,  // not required for force; a clutch offsets the tip from the grip
    // Explains a missing kDeviceReady or missing data: the computer ran the device's thread or the loop too
    // late. As far as is known, the device itself still answers.
    kDeviceHostLate = 1u << 3,
};

// State of the device as read in one tick.
struct DeviceState {
    Pose device_from_stylus;  // the stylus frame is the needle frame: tip at origin, +z to the hub
    std::uint32_t buttons = 0;
    std::uint32_t fresh = 1;  // 0: nothing new since the last read
    std::uint32_t flags = kDeviceReady | kDeviceHandOn;
    // Valid only with kDeviceClutch. Workspace limits, the wall and the energy account use the grip.
    Vec3 grip_at_m{0.0};       // device frame
    double force_share = 1.0;  // fraction of the model's force: 0 while the clutch is pressed

    Vec3 grip_m() const noexcept {
        return (flags & kDeviceClutch) != 0 ? grip_at_m : device_from_stylus.position_m;
    }
    double share() const noexcept { return (flags & kDeviceClutch) != 0 ? force_share : 1.0; }
};

class HapticDevice {
  public:
    virtual ~HapticDevice() = default;
    virtual const DeviceProfile& profile() const noexcept = 0;
    // Haptics thread. Returns the newest state. `now_ns` is the loop's time.
    virtual DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING = 0;
    // Haptics thread. Sets the force in the device frame. Called only by the loop, with the output stage's
    // force.
    virtual void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING = 0;
};

}  // namespace stylet::haptics
