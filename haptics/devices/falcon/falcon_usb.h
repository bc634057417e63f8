// The Falcon's FTDI chip over libusb: 0403:cb48, interface 0, bulk OUT 0x02, bulk IN 0x81 (libnifalcon's
// FalconComm.h). Built only with libusb (STYLET_LIBUSB).
#pragma once

#include <memory>
#include <vector>

#include "haptics/devices/falcon/ftdi_bus.h"

namespace stylet::haptics::falcon {

// The first Falcon found, or the one at `port` ("bus-port.port").
std::unique_ptr<FtdiBus> usbBus(const std::string& port = "");

// The Falcons plugged in now.
struct UsbPlace {
    std::string port;  // "1-3.2"
    std::string node;  // "/dev/bus/usb/001/004"
};
std::vector<UsbPlace> findFalcons();

}  // namespace stylet::haptics::falcon
