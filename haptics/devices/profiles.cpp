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

constexpr double kPhantomDamping_n_s_per_m = 0.005;

constexpr const char* kChai3d = "CHAI3D device table; mass, friction, damping unknown";
constexpr const char* kPhantom =
    "3D Systems and SensAble data sheets (mass, friction, resolution unproven); damping: least of the "
    "Phantom "
    "class";

DeviceProfile phantom(DeviceProfile p) {
    p.source = kPhantom;
    p.damping_n_s_per_m = kPhantomDamping_n_s_per_m;
    return p;
}

const std::array kProfiles{
    DeviceProfile{},
    phantom({.name = "touch",
             .force_peak_n = 3.3,
             .stiffness_n_per_m = 400.0,
             .force_continuous_n = 0.88,
             .mass_kg = 0.045,
             .friction_n = 0.26,
             .resolution_m = 55e-6}),
    phantom({.name = "touch-x",
             .force_peak_n = 7.9,
             .stiffness_n_per_m = 1000.0,
             .force_continuous_n = 1.75,
             .mass_kg = 0.045,
             .friction_n = 0.06,
             .resolution_m = 23e-6}),
    phantom({.name = "omni",
             .force_peak_n = 3.3,
             .stiffness_n_per_m = 700.0,
             .force_continuous_n = 0.88,
             .mass_kg = 0.045,
             .friction_n = 0.26,
             .resolution_m = 55e-6}),
    phantom({.name = "premium-1.5",
             .force_peak_n = 8.5,
             .stiffness_n_per_m = 800.0,
             .torque_axes = 3,
             .force_continuous_n = 1.4,
             .mass_kg = 0.136,
             .friction_n = 0.04,
             .resolution_m = 30e-6}),
    phantom({.name = "premium-3.0",
             .force_peak_n = 22.0,
             .stiffness_n_per_m = 1000.0,
             .torque_axes = 3,
             .force_continuous_n = 3.0,
             .mass_kg = 0.159,
             .friction_n = 0.2,
             .resolution_m = 20e-6}),
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
    DeviceProfile{.name = "omega.3",
                  .force_peak_n = 12.0,
                  .stiffness_n_per_m = 5000.0,
                  .source = kChai3d,
                  .senses_rotation = false},
    DeviceProfile{.name = "sigma.7",
                  .force_peak_n = 12.0,
                  .stiffness_n_per_m = 4000.0,
                  .source = kChai3d,
                  .torque_axes = 3},
    DeviceProfile{.name = "lambda.7",
                  .force_peak_n = 12.0,
                  .stiffness_n_per_m = 8000.0,
                  .source = kChai3d,
                  .torque_axes = 3},
    DeviceProfile{.name = "delta.3",
                  .force_peak_n = 20.0,
                  .stiffness_n_per_m = kUnknown,
                  .source = kChai3d,
                  .senses_rotation = false},
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
