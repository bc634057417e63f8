#include "haptics/devices/entry.h"
#ifdef STYLET_LIBUSB
#include "haptics/devices/falcon/falcon.h"
#include "haptics/devices/falcon/falcon_firmware.h"
#include "haptics/devices/falcon/falcon_usb.h"
#include "haptics/devices/permission_linux.h"
#endif

namespace stylet::haptics {

#ifdef STYLET_LIBUSB

namespace {

// Lists the Falcons on USB without opening them. It is therefore unknown whether a Falcon already has its
// firmware. Without --firmware, the entry of an accessible Falcon says that the firmware is needed.
void findFalcons(const DeviceOptions& options, std::vector<FoundDevice>& found) {
    const std::string unless =
        options.firmware.empty() ? "it needs its firmware after each power-up: pass your copy with --firmware"
                                 : "";
    for (const falcon::UsbPlace& place : falcon::findFalcons()) {
        const std::string problem = accessProblem(place.node);
        found.push_back(
            {"falcon", place.node, "Novint Falcon at usb " + place.port, problem.empty() ? unless : problem});
    }
}

falcon::Calibration falconCalibration(const DeviceOptions& options) {
    return options.calibration.empty() ? falcon::Calibration{} : falcon::loadCalibration(options.calibration);
}

DeviceProfile falconProfile(const DeviceOptions& options) {
    return falcon::makeProfile(falconCalibration(options));
}

std::unique_ptr<Driver> makeFalcon(const DeviceOptions& options, const Clock& clock) {
    falcon::Settings settings;
    if (!options.firmware.empty()) settings.firmware = falcon::loadFirmwareFile(options.firmware);
    settings.calibration = falconCalibration(options);
    return std::make_unique<falcon::FalconDriver>(falcon::usbBus(), clock, std::move(settings));
}

}  // namespace

extern const DeviceEntry kFalconEntry{
    {"falcon", "Novint Falcon (USB)", nullptr}, findFalcons, falconProfile, makeFalcon};

#else

extern const DeviceEntry kFalconEntry{
    {"falcon", "Novint Falcon (USB)", "libusb-1.0-0-dev"}, nullptr, nullptr, nullptr};

#endif

}  // namespace stylet::haptics
