#include "haptics/devices/spacemouse/spacemouse.h"

#include <algorithm>

namespace stylet::haptics {

namespace {

constexpr std::size_t kMaxCapReportBytes = 64;
constexpr int kMaxCapReports = 64;
constexpr int kMaxMalformed = 20;
constexpr double kStartMargin_m = 0.005;  // distance of the needle's start from the end of the reach
// A deflected cap reports at least every 16 ms (wireless). After this much silence it is treated as released.
constexpr std::int64_t kCapSilent_ns = 150'000'000;

// From the cap's frame (x right, y toward the user, z down) to the device's (x right, y up, z toward the
// user).
std::array<double, 6> inDeviceFrame(const std::array<int, 6>& a) noexcept {
    return {double(a[0]), double(-a[2]), double(a[1]), double(a[3]), double(-a[5]), double(a[4])};
}

}  // namespace

bool isSpaceMouseEntry(const HidEntry& entry) {
    return isSpaceMouse(entry.vendor, entry.product, entry.usage_page, entry.usage);
}

DeviceProfile spaceMouseProfile(const RateSettings& rate) noexcept {
    DeviceProfile p = inputOnlyProfile("SpaceMouse", "input only; its reach is that of the rate control");
    p.workspace_radius_m = rate.reach_m;
    return p;
}

SpaceMouse::SpaceMouse(const Clock& clock, const RateSettings& rate)
    : clock_(clock),
      rate_(rate),
      profile_(spaceMouseProfile(rate)),
      device_from_stylus_{.position_m = {0.0, 0.0, rate.reach_m - kStartMargin_m}} {}

DeviceStage SpaceMouse::open(std::string& why) {
    const std::vector<HidEntry> entries = listHid();
    const auto cap = std::find_if(entries.begin(), entries.end(), isSpaceMouseEntry);
    if (cap == entries.end()) {
        why = "no SpaceMouse is plugged in";
        return DeviceStage::absent;
    }
    if (!port_.open(cap->path, why)) return DeviceStage::failed;
    input_ = {};
    malformed_ = 0;
    last_ns_ = last_report_ns_ = clock_.now();
    return DeviceStage::ready;
}

DeviceStage SpaceMouse::exchange(const Vec3&, DeviceState& state, std::string& why) {
    if (!readPending(why)) return DeviceStage::failed;
    const std::int64_t now_ns = clock_.now();
    if (!input_.atRest() && (now_ns - last_report_ns_ > kCapSilent_ns || now_ns < last_report_ns_)) {
        input_.axes = {};
        why = "the SpaceMouse stopped sending while its cap was pushed: treated as released";
    }
    stepRate(device_from_stylus_, inDeviceFrame(input_.axes), rate_, double(now_ns - last_ns_) * 1e-9);
    last_ns_ = now_ns;
    state.device_from_stylus = device_from_stylus_;
    state.buttons = input_.buttons;
    state.fresh = 1;
    return DeviceStage::ready;
}

bool SpaceMouse::readPending(std::string& why) {
    std::array<unsigned char, kMaxCapReportBytes> bytes;
    for (int i = 0; i < kMaxCapReports; ++i) {
        const int count = port_.read(bytes, 0, why);
        if (count < 0) return false;
        if (count == 0) return true;
        if (parseSpaceMouseReport({bytes.data(), std::size_t(count)}, input_) !=
            SpaceMouseReport::malformed) {
            malformed_ = 0;
            last_report_ns_ = clock_.now();
        } else if (++malformed_ >= kMaxMalformed) {
            why = "its reports are not those of a SpaceMouse: unplug it and plug it in again";
            return false;
        }
    }
    return true;
}

}  // namespace stylet::haptics
