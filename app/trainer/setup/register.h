// `stylet register`: registers the haptic device in the headset's room and stores the result.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/setup/register_view.h"
#include "app/trainer/stores/registration_store.h"
#include "haptics/devices/devices.h"
#include "haptics/loop/loop.h"
#include "xr/registration/registration.h"

namespace stylet::trainer {

struct RegisterOptions {
    std::string device;  // device kind, or "replay"
    haptics::DeviceOptions device_options;
    std::filesystem::path trace;  // CSV file for "replay"
    int points = 8;               // number of points to touch
    bool in_motion = false;
    bool redo = false;           // do not check first whether an earlier registration is still valid
    int touches = 1;             // points to touch for that check
    std::string hand = "right";  // hand that holds the controller
    std::vector<double> grip_from_tip_mm{};  // x, y, z if the controller's tip is known, else empty
    std::filesystem::path out{};             // default: where `stylet run` looks for it
    bool validation = false;
};

// Returns the exit status: 0 if a registration was stored or an earlier one is still valid, else 1. Throws
// DataError, std::runtime_error.
int registerDevice(const RegisterOptions&);

// Same for a device that is ready and an open view. `clock` is used on two threads. `each_frame` is called
// before every frame. Returns true if a registration was stored or an earlier one is still valid.
bool registerWith(const RegisterOptions&, haptics::HapticDevice&, RegisterView&, const haptics::Clock& clock,
                  const std::function<void()>& each_frame = {});

// Folder of the stored registrations.
std::filesystem::path registrationsFolder();
RegistrationKey keyOf(const std::string& kind, const haptics::DeviceProfile&, const std::string& space,
                      const std::string& generation);
// Cube in which the points lie: 80 mm wide, or smaller if the device reaches less. Centred at `grip_m` if
// the workspace is unknown.
xr::registration::Cube cubeOf(const haptics::DeviceProfile&, const Vec3& grip_m);
// registrationOf() converts a fit to its stored form. storedOf() returns the part needed to check whether
// the registration is still valid.
Registration registrationOf(const xr::registration::Fit&, const xr::registration::Cube&,
                            const RegistrationKey&, const std::string& date);
xr::registration::Stored storedOf(const Registration&);

}  // namespace stylet::trainer
