// The USB reports of a WoodenHaptics board (mbed LPC1768, 14-byte reports), as bytes.
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
// board cuts its motors 0.5 s after the last of these.
using WoodenCommand = std::array<unsigned char, 1 + kWoodenReportBytes>;
WoodenCommand encodeWoodenCurrents(const std::array<std::int16_t, 3>& current_ma) noexcept;
// Sets the encoders; the motors get no current meanwhile. Encoders a, b, c travel as the attributes, d, e, f
// in the currents' place.
WoodenCommand encodeWoodenCalibration(const std::array<std::int16_t, 6>& encoders) noexcept;

// Nearest whole milliamperes within +-2 A; what is no number is 0.
std::int16_t milliamps(double current_a) noexcept;

}  // namespace stylet::haptics
