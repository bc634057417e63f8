// Pose of a haptic device in the headset's room. `stylet register` writes it, `stylet run` reads it. There is
// one JSON file per device and space.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "base/geometry.h"

namespace stylet::trainer {

// Identifies what a registration is valid for. It must not be used with any other device, unit or space.
struct RegistrationKey {
    std::string device;      // device kind, as in `--device`
    std::string unit;        // name of the unit (DeviceProfile::name)
    std::string space;       // "stationary", "stage", "local_floor", "local"
    std::string generation;  // generation of a stationary space; empty if the runtime reports none
    friend bool operator==(const RegistrationKey&, const RegistrationKey&) = default;
};

struct Registration {
    RegistrationKey key;
    // p_stage = stage_from_device * (scale * p_device)
    Pose stage_from_device;
    double scale = 1.0;           // factor on device positions
    Vec3 stylus_from_tip_m{0.0};  // tip in the frame that the device reports
    Vec3 grip_from_tip_m{0.0};    // the pointer's tip in the controller's grip frame
    double latency_s = 0.0;       // delay of the controller's poses relative to the device's
    double fre_m = 0.0;           // RMS residual of the points used
    double tre_mean_m = 0.0,
           tre_worst_m = 0.0;      // predicted RMS error over the working cube
    Vec3 centre_m{0.0};            // centre of that cube, device frame
    int points = 0, rejected = 0;  // used; rejected as outliers
    std::string date;              // "2026-11-21T20:15:00Z"

    // Position of the device's tip in the stage frame.
    Vec3 inStage(const Pose& device_from_stylus) const {
        return stage_from_device * (scale * (device_from_stylus * stylus_from_tip_m));
    }
    // Rigid pose that agrees with the scaled transform at the cube's centre. At 40 mm from the centre, a
    // scale error of 0.5 % then causes an error of 0.2 mm.
    Pose rigid() const {
        return {stage_from_device.rotation,
                stage_from_device.position_m + stage_from_device.direction((scale - 1.0) * centre_m)};
    }
};

// Rejects unknown or missing fields, wrong types and numbers out of range. Throws DataError that names
// `file`.
Registration parseRegistration(std::string_view json, const std::filesystem::path& file);
Registration loadRegistration(const std::filesystem::path& file);
std::string registrationText(const Registration&);
// Writes the file atomically. The data is on disk on return. Throws DataError.
void saveRegistration(const Registration&, const std::filesystem::path& file);

// Path of the file for this key.
std::filesystem::path registrationFile(const std::filesystem::path& folder, const RegistrationKey&);
// Returns nothing if there is none. Throws DataError if the file is invalid.
std::optional<Registration> findRegistration(const std::filesystem::path& folder, const RegistrationKey&);
// Newest registration of a device in any space. Throws DataError if none is found and a file is invalid.
std::optional<Registration> newestRegistration(const std::filesystem::path& folder, const std::string& device,
                                               const std::string& unit);

}  // namespace stylet::trainer
