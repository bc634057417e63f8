// `stylet register`: shows the haptic device its place in the headset's room, and keeps what came of it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/trainer/register_view.h"
#include "app/trainer/registration_store.h"
#include "haptics/devices/devices.h"
#include "haptics/loop.h"
#include "xr/registration/registration.h"

namespace stylet::trainer {

struct RegisterOptions {
    std::string device;  // a kind, or "replay"
    haptics::DeviceOptions device_options;
    std::filesystem::path trace;  // of "replay"
    int points = 8;               // to be held
    bool in_motion = false;
    bool redo = false;                       // without asking first whether an earlier one still holds
    int touches = 1;                         // when asking
    std::string hand = "right";              // that holds the controller
    std::vector<double> grip_from_tip_mm{};  // three, where the controller's tip is known
    std::filesystem::path out{};             // default: where `stylet run` looks for it
    bool validation = false;
};

// The exit status of the command: 0 kept or still right, 1 given up. Throws patient::DataError,
// std::runtime_error.
int registerDevice(const RegisterOptions&);

// The same on a device that is ready, with a view that is open. `clock` is read and sleeps on two threads.
// `each_frame` is called before every frame. Returns true when a registration was stored, or an earlier one
// still holds.
bool registerWith(const RegisterOptions&, haptics::HapticDevice&, RegisterView&, const haptics::Clock& clock,
                  const std::function<void()>& each_frame = {});

// Where registrations are kept.
std::filesystem::path registrationsFolder();
RegistrationKey keyOf(const std::string& kind, const haptics::DeviceProfile&, const std::string& space,
                      const std::string& generation);
// The cube that the tip is asked into: as much of 80 mm as the device reaches.
xr::registration::Cube cubeOf(const haptics::DeviceProfile&, const patient::Vec3& grip_m);
// A fit as it is stored, and what of it answers whether it still holds.
Registration registrationOf(const xr::registration::Fit&, const xr::registration::Cube&,
                            const RegistrationKey&, const std::string& date);
xr::registration::Stored storedOf(const Registration&);

}  // namespace stylet::trainer
