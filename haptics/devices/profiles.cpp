// Sources. Force, stiffness and workspace of the Force Dimension, SensAble and Novint devices: the makers'
// data sheets as stored in CHAI3D's device table. Polhem: haptikfabrikenapi. Falcon's resolution: computed
// from libnifalcon's geometry at the centre of its workspace. Mass at the tip, back-drive friction and
// resolution of the Phantoms: SensAble's data sheets of 2009, quoted from memory because no stored copy was
// found (unproven). Damping of the Phantoms: the least of the range 0.005 to 0.1 N s/m that published
// identifications of the Phantom class report. Values that no source gives are kUnknown.
#include "haptics/devices/profiles.h"

#include <array>

namespace stylet::haptics {

namespace {

constexpr const char* kChai3d = "CHAI3D device table; mass, friction, damping unknown";

// The Phantoms of SensAble and 3D Systems.
struct PhantomRow {
    const char* name;
    double force_peak_n, force_continuous_n, stiffness_n_per_m;
    int torque_axes;
    double mass_kg, friction_n, resolution_m;
};

DeviceProfile phantom(const PhantomRow& row) {
    DeviceProfile p{.name = row.name,
                    .force_peak_n = row.force_peak_n,
                    .stiffness_n_per_m = row.stiffness_n_per_m,
                    .source =
                        "3D Systems and SensAble data sheets (mass, friction, resolution unproven); "
                        "damping: least of the Phantom class"};
    p.torque_axes = row.torque_axes;
    p.force_continuous_n = row.force_continuous_n;
    p.mass_kg = row.mass_kg;
    p.damping_n_s_per_m = 0.005;
    p.friction_n = row.friction_n;
    p.resolution_m = row.resolution_m;
    return p;
}

// A device is assumed to sense rotation only if it has torque axes.
DeviceProfile forceDimension(const char* name, double force_peak_n, double stiffness_n_per_m,
                             int torque_axes) {
    return {.name = name,
            .force_peak_n = force_peak_n,
            .stiffness_n_per_m = stiffness_n_per_m,
            .source = kChai3d,
            .torque_axes = torque_axes,
            .senses_rotation = torque_axes > 0};
}

const std::array kProfiles{
    DeviceProfile{},
    phantom({"touch", 3.3, 0.88, 400.0, 0, 0.045, 0.26, 55e-6}),
    phantom({"touch-x", 7.9, 1.75, 1000.0, 0, 0.045, 0.06, 23e-6}),
    phantom({"omni", 3.3, 0.88, 700.0, 0, 0.045, 0.26, 55e-6}),
    phantom({"premium-1.5", 8.5, 1.4, 800.0, 3, 0.136, 0.04, 30e-6}),
    phantom({"premium-3.0", 22.0, 3.0, 1000.0, 3, 0.159, 0.2, 20e-6}),
    DeviceProfile{.name = "falcon",
                  .force_peak_n = 8.0,
                  .stiffness_n_per_m = 3000.0,
                  .source =
                      "CHAI3D device table; resolution computed from libnifalcon's geometry; mass, friction, "
                      "damping unknown, force uncalibrated",
                  .senses_rotation = false,
                  .force_calibrated = false,
                  .resolution_m = 42e-6,
                  .workspace_radius_m = 0.04},
    forceDimension("omega.3", 12.0, 5000.0, 0),
    forceDimension("sigma.7", 12.0, 4000.0, 3),
    forceDimension("lambda.7", 12.0, 8000.0, 3),
    forceDimension("delta.3", 20.0, kUnknown, 0),
    DeviceProfile{.name = "polhem",
                  .force_peak_n = 5.0,
                  .stiffness_n_per_m = 2000.0,
                  .source = "haptikfabrikenapi, polhem_v3; mass, friction, damping unknown",
                  .workspace_radius_m = 0.15},
    DeviceProfile{.name = "inverse3",
                  .force_peak_n = kUnknown,
                  .stiffness_n_per_m = kUnknown,
                  .source = "Haply's service documentation gives no limits: the user confirms them",
                  .senses_rotation = false},
};

}  // namespace

std::span<const DeviceProfile> deviceProfiles() noexcept {
    return kProfiles;
}

const DeviceProfile* findProfile(std::string_view name) noexcept {
    for (const DeviceProfile& profile : kProfiles)
        if (name == profile.name) return &profile;
    return nullptr;
}

}  // namespace stylet::haptics
