// The Falcon's FTDI chip over libusb: 0403:cb48, interface 0, bulk OUT 0x02, bulk IN 0x81 (libnifalcon's
// FalconComm.h). Built where libusb is (STYLET_LIBUSB).
#pragma once

#include <memory>
#include <vector>

#include "haptics/devices/ftdi_bus.h"

namespace stylet::haptics::falcon {

// The first Falcon found, or the one at `place` ("bus-port.port", as `falconPlaces` gives it).
std::unique_ptr<FtdiBus> usbBus(const std::string& place = "");

// Where Falcons are plugged in now.
std::vector<std::string> falconPlaces();

}  // namespace stylet::haptics::falcon
