#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "haptics/devices/spacemouse/spacemouse_report.h"
#include "haptics/devices/woodenhaptics/woodenhaptics_protocol.h"

using namespace stylet::haptics;

namespace {

// A rejected report changes nothing. Axis values stay within four times full scale.
void checkSpaceMouseReport(std::span<const unsigned char> report, SpaceMouseInput& input) {
    const SpaceMouseInput before = input;
    const SpaceMouseReport taken = parseSpaceMouseReport(report, input);
    const bool same = input.axes == before.axes && input.buttons == before.buttons &&
                      input.battery_percent == before.battery_percent;
    if (taken == SpaceMouseReport::malformed && !same) std::abort();
    if (std::any_of(input.axes.begin(), input.axes.end(),
                    [](int a) { return std::abs(a) > 4 * kSpaceMouseFullScale; }))
        std::abort();
    if (input.battery_percent > 100) std::abort();
}

// An accepted report contains encoder counts. A calibration made from them must encode the same counts.
void checkWoodenReport(std::span<const unsigned char> bytes) {
    const auto report = decodeWoodenReport(bytes);
    if (report.has_value() != (bytes.size() == kWoodenReportBytes)) std::abort();
    if (!report) return;
    const WoodenCommand back = encodeWoodenCalibration(report->encoders);
    if (!std::equal(bytes.begin(), bytes.begin() + 6, back.begin() + 9)) std::abort();
    if (!std::equal(bytes.begin() + 6, bytes.begin() + 12, back.begin() + 1)) std::abort();
}

}  // namespace

// The input is a sequence of reports: a length, then that many bytes.
// HZ-FORCE-21, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::span<const std::uint8_t> left(data, size);
    SpaceMouseInput input;
    while (!left.empty()) {
        const std::size_t count = std::min<std::size_t>(left[0] % 65, left.size() - 1);
        checkSpaceMouseReport(left.subspan(1, count), input);
        checkWoodenReport(left.subspan(1, count));
        left = left.subspan(1 + count);
    }
    return 0;
}
