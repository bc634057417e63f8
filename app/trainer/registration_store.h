// Where a haptic device stands in the headset's room, as `stylet register` found it and `stylet run` uses it.
// One JSON file for each device and space.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "patient/geometry.h"

namespace stylet::trainer {

// What a registration holds for. Anything else measured against it is another place.
struct RegistrationKey {
    std::string device;      // kind, as `--device` names it
    std::string unit;        // which of that kind: what it calls itself (DeviceProfile::name)
    std::string space;       // "stationary", "stage", "local_floor", "local"
    std::string generation;  // of a stationary space; empty where the runtime counts none
    friend bool operator==(const RegistrationKey&, const RegistrationKey&) = default;
};

struct Registration {
    RegistrationKey key;
    // p_stage = stage_from_device * (scale * p_device)
    patient::Pose stage_from_device;
    double scale = 1.0;                    // of the device's millimetres
    patient::Vec3 stylus_from_tip_m{0.0};  // where the tip is in the frame that the device reports
    patient::Vec3 grip_from_tip_m{0.0};    // the pointer's tip in the controller's grip frame
    double latency_s = 0.0;                // the controller's poses are so much later than the device's
    double fre_m = 0.0;                    // root mean square residual of the points that were kept
    double tre_mean_m = 0.0,
           tre_worst_m = 0.0;      // predicted, over the cube the tip works in; root mean square
    patient::Vec3 centre_m{0.0};   // of that cube, device frame
    int points = 0, rejected = 0;  // kept; taken for wrong
    std::string date;              // "2026-11-21T20:15:00Z"

    // Where the device's tip is in the room.
    patient::Vec3 inStage(const patient::Pose& device_from_stylus) const {
        return stage_from_device * (scale * (device_from_stylus * stylus_from_tip_m));
    }
    // The rigid pose that agrees with the scale at the centre: half a percent is then 0.2 mm at 40 mm from
    // it.
    patient::Pose rigid() const {
        return {stage_from_device.rotation,
                stage_from_device.position_m + stage_from_device.direction((scale - 1.0) * centre_m)};
    }
};

// Strict: an unknown or missing field, a wrong type, a number out of range. Throws patient::DataError; `file`
// is named.
Registration parseRegistration(std::string_view json, const std::filesystem::path& file);
Registration loadRegistration(const std::filesystem::path& file);
std::string registrationText(const Registration&);
// Whole or not at all, and on the disk when it returns. Throws patient::DataError.
void saveRegistration(const Registration&, const std::filesystem::path& file);

// Where the one of this key belongs.
std::filesystem::path registrationFile(const std::filesystem::path& folder, const RegistrationKey&);
// Nothing when there is none. Throws patient::DataError when there is a bad one.
std::optional<Registration> findRegistration(const std::filesystem::path& folder, const RegistrationKey&);
// The newest of a device, whatever its space. Throws patient::DataError when there is none but a bad file.
std::optional<Registration> newestRegistration(const std::filesystem::path& folder, const std::string& device,
                                               const std::string& unit);

}  // namespace stylet::trainer
