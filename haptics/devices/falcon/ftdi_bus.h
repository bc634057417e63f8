// Interface to an FTDI serial chip. Implemented by USB in falcon_usb.h and by an emulator in the tests.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "haptics/devices/driver.h"

namespace stylet::haptics {

enum class BusResult : std::uint8_t {
    ok,
    late,  // timed out; the bus still works
    lost,  // unplugged or broken, see `why`
};

// One IN packet without its two modem-status bytes: at most 62 bytes, often none.
struct BusBytes {
    std::array<std::uint8_t, 62> bytes{};
    std::size_t count = 0;
    std::span<const std::uint8_t> span() const noexcept { return {bytes.data(), count}; }
};

// Device's thread. Each call returns within about `wait_ms`.
class FtdiBus {
  public:
    virtual ~FtdiBus() = default;
    // Returns absent, failed (with `why`) or opening.
    virtual DeviceStage open(std::string& why) = 0;
    // A vendor request without data.
    virtual BusResult control(std::uint8_t request, std::uint16_t value, std::string& why) = 0;
    // Writes all bytes, or returns late.
    virtual BusResult write(std::span<const std::uint8_t>, int wait_ms, std::string& why) = 0;
    // ok with no bytes: the chip answered but has no data yet.
    virtual BusResult read(BusBytes&, int wait_ms, std::string& why) = 0;
    virtual void close() noexcept = 0;
};

// The chip's vendor requests, bmRequestType 0x40 (libnifalcon's FalconCommLibUSB.cpp).
enum FtdiRequest : std::uint8_t {
    kFtdiReset = 0,    // 1 purges the receive buffer, 2 the transmit buffer
    kFtdiModem = 1,    // 0x0100, 0x0101: DTR low, high; 0x0200: RTS low
    kFtdiFlow = 2,     // 0: off
    kFtdiBaud = 3,     // the divisor
    kFtdiLine = 4,     // 8: eight bits, no parity, one stop bit
    kFtdiLatency = 9,  // latency timer, ms until the chip sends a partial packet
};
inline constexpr std::uint16_t kPurgeReceived = 1, kPurgeToSend = 2;

}  // namespace stylet::haptics
