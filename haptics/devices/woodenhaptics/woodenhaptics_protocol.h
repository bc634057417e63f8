// USB reports of a WoodenHaptics board (mbed LPC1768, 14-byte reports), as bytes.
// Facts from forsslund/haptikfabrikenapi (firmware/main.cpp). Unproven on hardware here.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace stylet::haptics {

// Board to PC: 7 x int16, little-endian.
inline constexpr std::size_t kWoodenReportBytes = 14;
struct WoodenReport {
    std::array<std::int16_t, 6> encoders{};  // a..f
    std::int16_t info = 0;                   // 1: the calibration button was pressed
};
std::optional<WoodenReport> decodeWoodenReport(std::span<const unsigned char> bytes) noexcept;

// PC to board: report id 0, then 7 x int16: currents of motors a, b, c in mA, command, three attributes. The
// board switches its motors off 0.5 s after the last of these.
using WoodenCommand = std::array<unsigned char, 1 + kWoodenReportBytes>;
WoodenCommand encodeWoodenCurrents(const std::array<std::int16_t, 3>& current_ma) noexcept;
// Sets the encoders; the motors have no current meanwhile. Encoders a, b, c are sent as the attributes, and
// d, e, f in place of the currents.
WoodenCommand encodeWoodenCalibration(const std::array<std::int16_t, 6>& encoders) noexcept;

// Rounds to whole milliamperes and clamps to +-2 A. Non-finite input gives 0.
std::int16_t milliamps(double current_a) noexcept;

}  // namespace stylet::haptics
