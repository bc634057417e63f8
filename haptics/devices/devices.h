// The list of supported devices: which are plugged in, what prevents their use, and their drivers.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "haptics/devices/clutch.h"
#include "haptics/devices/driver.h"
#include "haptics/devices/entry.h"
#include "haptics/devices/falcon/calibrate.h"
#include "haptics/devices/polled.h"
#include "haptics/devices/profiles.h"
#include "haptics/devices/replay.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics {

// In display order.
std::span<const DeviceKind> deviceKinds() noexcept;

// Lists the devices plugged in now. Opens none of them.
std::vector<FoundDevice> findDevices(const DeviceOptions&);

// Returns the profile of a kind of device, as far as it is known before the device is opened. Unknown values
// are NaN. May read the file DeviceOptions::model. Throws DataError.
DeviceProfile deviceProfile(std::string_view kind, const DeviceOptions&);

// Returns the SHA-256 digest of the file DeviceOptions::firmware, or an empty string if no file is named. The
// digest is stored with the attempt. Throws DataError.
std::string firmwareDigest(const DeviceOptions&);

// Creates the driver for PolledDevice. The clock is used on the device's thread. Throws DataError:
// unknown kind, not in this build, or a file that is missing or invalid.
std::unique_ptr<Driver> makeDriver(std::string_view kind, const DeviceOptions&, const Clock&);

}  // namespace stylet::haptics
