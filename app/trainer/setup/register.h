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
    bool redo = false;           // skip the check whether an earlier registration is still valid
    int touches = 1;             // points to touch for that check
    std::string hand = "right";  // hand that holds the controller
    // Tip in the controller's grip frame: x, y, z if known, else empty.
    std::vector<double> grip_from_tip_mm{};
    std::filesystem::path out{};  // output file; default: the place where `stylet run` looks for it
    bool validation = false;
};

// Returns the exit status: 0 if a registration was stored or an earlier one is still valid, else 1. Throws
// UsageError, DataError, EnvironmentError.
int registerDevice(const RegisterOptions&);

// Same for a device that is ready and an open view. `clock` is used on two threads. `each_frame` is called
// before every frame. Returns true if a registration was stored or an earlier one is still valid.
bool registerWith(const RegisterOptions&, haptics::HapticDevice&, RegisterView&, const haptics::Clock& clock,
                  const std::function<void()>& each_frame = {});

// Folder of the stored registrations.
std::filesystem::path registrationsFolder();
RegistrationKey makeRegistrationKey(const std::string& kind, const haptics::DeviceProfile&,
                                    const std::string& space, const std::string& generation);
// Cube that contains the points. It is 80 mm wide, or smaller if the device has less reach. If the workspace
// is unknown, its centre is `grip_m`.
xr::registration::Cube workingCube(const haptics::DeviceProfile&, const Vec3& grip_m);
// makeRegistration() converts a fit to its stored form. toStored() returns the part that is needed to check
// whether the registration is still valid.
Registration makeRegistration(const xr::registration::Fit&, const xr::registration::Cube&,
                              const RegistrationKey&, const std::string& date);
xr::registration::StoredRegistration toStored(const Registration&);

}  // namespace stylet::trainer
