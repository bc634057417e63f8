#include "haptics/devices/woodenhaptics/woodenhaptics_protocol.h"

#include <algorithm>
#include <cmath>

#include "haptics/devices/woodenhaptics/woodenhaptics_arm.h"

namespace stylet::haptics {

namespace {

constexpr std::int16_t kCommandCurrents = 0, kCommandSetEncoders = 1;

std::int16_t wordAt(std::span<const unsigned char> bytes, std::size_t word) noexcept {
    return std::int16_t(std::uint16_t(bytes[2 * word] | bytes[2 * word + 1] << 8));
}

WoodenCommand packCommand(const std::array<std::int16_t, 7>& words) noexcept {
    WoodenCommand bytes{};
    for (std::size_t i = 0; i < words.size(); ++i) {
        const auto word = std::uint16_t(words[i]);
        bytes[1 + 2 * i] = static_cast<unsigned char>(word & 0xFF);
        bytes[2 + 2 * i] = static_cast<unsigned char>(word >> 8);
    }
    return bytes;
}

}  // namespace

std::optional<WoodenReport> decodeWoodenReport(std::span<const unsigned char> bytes) noexcept {
    if (bytes.size() != kWoodenReportBytes) return std::nullopt;
    WoodenReport report;
    for (std::size_t i = 0; i < report.encoders.size(); ++i)
        report.encoders[i] = wordAt(bytes, i);
    report.info = wordAt(bytes, 6);
    return report;
}

WoodenCommand encodeWoodenCurrents(const std::array<std::int16_t, 3>& ma) noexcept {
    return packCommand({ma[0], ma[1], ma[2], kCommandCurrents, 0, 0, 0});
}

WoodenCommand encodeWoodenCalibration(const std::array<std::int16_t, 6>& e) noexcept {
    return packCommand({e[3], e[4], e[5], kCommandSetEncoders, e[0], e[1], e[2]});
}

std::int16_t milliamps(double current_a) noexcept {
    if (!std::isfinite(current_a)) return 0;
    return std::int16_t(std::lround(1000.0 * std::clamp(current_a, -kMaxCurrent_a, kMaxCurrent_a)));
}

}  // namespace stylet::haptics
