#include "haptics/devices/woodenhaptics/woodenhaptics.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

namespace stylet::haptics {

namespace {

constexpr std::uint16_t kMbedVendor = 0x1234, kMbedProduct = 0x0006;
constexpr std::size_t kMaxBoardReportBytes = 65;

// The board answers each command with a report. One that takes longer than this counts as missed.
constexpr int kReplyWait_ms = 5;
constexpr int kMissesUntilZero = 3;   // 15 ms: currents go to zero
constexpr int kMissesUntilLost = 50;  // 250 ms
constexpr int kMaxBoardReports = 64;
constexpr int kZerosAtEnd = 3;

// If a body seems to turn further than this between two reports, its encoder or the report is wrong.
constexpr double kMaxTurn_rad = 0.2;
constexpr double kMaxWristTurn_rad = 1.0;
// If two commands are further apart than kUsualGap_ns, the PC stalled or the board did not answer, and motion
// was missed. For each kStallUnit_s the limits grow by their own size, kMaxStall times at most.
constexpr std::int64_t kUsualGap_ns = 10'000'000;
constexpr double kStallUnit_s = 0.02, kMaxStall = 15.0;
// The first reports after a stall may be older than its end. The one after so many is not.
constexpr int kReportsOnTheWay = 3;

constexpr const char* kParkAndPress =
    "park the arm in its calibration pose and press the button on its board";
constexpr int kHomingTries = 50;
constexpr int kCalibrationSlack = 100;  // counts: the parked arm may still move a little

// The stylus button is encoded in encoder d, which never reaches such values by itself.
constexpr int kButtonOffset = 10000, kButtonAbove = 5000;

// Device frame: +z toward the user, +y up; base frame: +x toward the user, +z up.
const Quat kDeviceFromBase{0.5, -0.5, -0.5, -0.5};

WoodenReport withoutButton(WoodenReport report, bool& pressed) noexcept {
    pressed = report.encoders[3] > kButtonAbove;
    if (pressed) report.encoders[3] = std::int16_t(report.encoders[3] - kButtonOffset);
    return report;
}

bool near(const std::array<std::int16_t, 6>& a, const std::array<std::int16_t, 6>& b) noexcept {
    for (std::size_t i = 0; i < 3; ++i)
        if (std::abs(a[i] - b[i]) > kCalibrationSlack) return false;
    return true;
}

}  // namespace

bool isWoodenBoard(const HidEntry& entry) noexcept {
    return entry.vendor == kMbedVendor && entry.product == kMbedProduct;
}

DeviceProfile makeProfile(const WoodenModel& model) noexcept {
    DeviceProfile p;
    p.name = model.name.c_str();
    p.source = "the device's model file; its mechanics (mass, damping, friction) are unknown";
    p.force_peak_n = model.force_peak_n;
    p.stiffness_n_per_m = model.stiffness_n_per_m;
    p.senses_rotation = model.hasWrist();
    // Resolution with the upper arm vertical and the forearm level, in the middle of these arms' workspaces.
    p.resolution_m = armResolution_m(model, {0.0, 0.0, 0.5 * std::numbers::pi});
    p.workspace_radius_m = model.workspace_radius_m;
    return p;
}

WoodenHaptics::WoodenHaptics(const Clock& clock, const WoodenModel& model)
    : clock_(clock), model_(model), profile_(makeProfile(model_)) {}

DeviceStage WoodenHaptics::open(std::string& why) {
    std::vector<HidEntry> boards = listHid();
    std::erase_if(boards, [](const HidEntry& entry) { return !isWoodenBoard(entry); });
    if (boards.empty()) {
        why = "no board of its kind (1234:0006) is plugged in";
        return DeviceStage::absent;
    }
    if (boards.size() > 1) {
        why = "several boards (1234:0006) are plugged in; leave only the device's own";
        return DeviceStage::failed;
    }
    if (!port_.open(boards.front().path, why)) return DeviceStage::failed;
    homing_ = Homing::clearButton;
    homing_tries_ = missed_ = 0;
    command_ns_ = clock_.now();
    stall_ns_ = 0;
    WoodenReport old;
    if (readReport(old, why) == ReadResult::lost) return DeviceStage::failed;
    missed_ = 0;
    return DeviceStage::opening;
}

void WoodenHaptics::close() noexcept {
    if (!port_.isOpen()) return;
    // The board reads a command only after its report has been read.
    std::string ignored;
    WoodenReport report;
    for (int i = 0; i < kZerosAtEnd; ++i)
        if (!port_.write(encodeWoodenCurrents({0, 0, 0}), ignored) ||
            readReport(report, ignored) == ReadResult::lost)
            break;
    port_.close();
}

DeviceStage WoodenHaptics::exchange(const Vec3& force_n, DeviceState& state, std::string& why) {
    const std::int64_t last_ns = std::exchange(command_ns_, clock_.now());
    if (const std::int64_t late_ns = command_ns_ - last_ns - kUsualGap_ns; late_ns > 0)
        stall_ns_ += late_ns, reports_since_stall_ = 0;
    if (!port_.write(makeCommand(force_n), why)) return DeviceStage::failed;
    WoodenReport report;
    switch (readReport(report, why)) {
        case ReadResult::lost:
            return DeviceStage::failed;
        case ReadResult::nothing:
            return handleMissed(why);
        case ReadResult::report:
            break;
    }
    return processReport(report, state, why);
}

WoodenCommand WoodenHaptics::makeCommand(const Vec3& force_n) const noexcept {
    if (homing_ == Homing::calibrate || homing_ == Homing::clearButton) {
        // Before the first report there are no encoder values to set.
        return homing_tries_ > 0 ? encodeWoodenCalibration(set_encoders_) : encodeWoodenCurrents({0, 0, 0});
    }
    // If the arm's pose is unknown, so is the effect of a current.
    if (homing_ != Homing::done || missed_ >= kMissesUntilZero) return encodeWoodenCurrents({0, 0, 0});
    const Vec3 base_n = glm::conjugate(kDeviceFromBase) * force_n;
    const Vec3 motor_a = armCurrents(model_, armAngles_rad(model_, counts_), base_n).motor_a;
    return encodeWoodenCurrents({milliamps(motor_a.x), milliamps(motor_a.y), milliamps(motor_a.z)});
}

// Reads the newest waiting report. The board sends nothing more until it receives a command.
WoodenHaptics::ReadResult WoodenHaptics::readReport(WoodenReport& report, std::string& why) {
    std::array<unsigned char, kMaxBoardReportBytes> bytes;
    ReadResult result = ReadResult::nothing;
    garbled_ = false;
    for (int i = 0; i < kMaxBoardReports; ++i) {
        const int count = port_.read(bytes, i == 0 ? kReplyWait_ms : 0, why);
        if (count < 0) return ReadResult::lost;
        if (count == 0) break;
        const auto decoded = decodeWoodenReport({bytes.data(), std::size_t(count)});
        garbled_ = !decoded;
        if (!decoded) continue;
        report = *decoded;
        result = ReadResult::report;
    }
    return result;
}

DeviceStage WoodenHaptics::handleMissed(std::string& why) {
    const char* const what = garbled_ ? "its reports cannot be right" : "it gives no reports";
    if (++missed_ >= kMissesUntilLost) {
        why = fmt::format("the board stays connected, but {}: unplug it and plug it in again", what);
        return DeviceStage::failed;
    }
    const bool homed = homing_ == Homing::done;
    if (missed_ >= kMissesUntilZero)
        why = what;
    else if (!homed)
        why = kParkAndPress;
    return homed ? DeviceStage::ready : DeviceStage::needsHoming;
}

DeviceStage WoodenHaptics::processReport(const WoodenReport& with_button, DeviceState& state,
                                         std::string& why) {
    bool pressed = false;
    const WoodenReport report = withoutButton(with_button, pressed);
    if (homing_ != Homing::done) return home(report, why);
    if (report.info == 1) {
        // The arm may be anywhere, so only a press after this one homes it.
        homing_ = Homing::clearButton;
        homing_tries_ = 0;
        return home(report, why);
    }
    if (!addMotion(report)) {
        garbled_ = true;
        return handleMissed(why);
    }
    missed_ = 0;
    const Vec3 angles_rad = armAngles_rad(model_, counts_);
    state.device_from_stylus.position_m = kDeviceFromBase * armPosition_m(model_, angles_rad);
    state.device_from_stylus.rotation =
        kDeviceFromBase * armRotation(model_, angles_rad, counts_) * glm::conjugate(kDeviceFromBase);
    state.buttons = pressed ? 1u : 0u;
    state.fresh = 1;
    return DeviceStage::ready;
}

DeviceStage WoodenHaptics::home(const WoodenReport& report, std::string& why) {
    missed_ = 0;
    why = kParkAndPress;
    const bool setting_encoders = homing_ == Homing::clearButton || homing_ == Homing::calibrate;
    if (setting_encoders && homing_tries_ > 0 && report.info == 0 && near(report.encoders, set_encoders_)) {
        const bool homed = homing_ == Homing::calibrate;
        homing_ = homed ? Homing::done : Homing::awaitButton;
        homing_tries_ = 0;
        if (homed) {
            resetCounts(report);
            why.clear();
            return DeviceStage::ready;
        }
    } else if (homing_ == Homing::clearButton && report.info == 0) {
        homing_ = Homing::awaitButton;
    } else if (homing_ == Homing::awaitButton && report.info == 1) {
        homing_ = Homing::calibrate;
        set_encoders_ = model_.calibration_counts;
        homing_tries_ = 1;
    } else if (setting_encoders) {
        if (homing_ == Homing::clearButton) set_encoders_ = report.encoders;
        if (++homing_tries_ > kHomingTries) {
            why = "the board does not accept its calibration";
            return DeviceStage::failed;
        }
    }
    return DeviceStage::needsHoming;
}

void WoodenHaptics::resetCounts(const WoodenReport& report) noexcept {
    raw_ = report.encoders;
    std::copy(raw_.begin(), raw_.end(), counts_.begin());
    stall_ns_ = 0;
}

// Adds the encoder motion since the last report, unwrapping the 16-bit counters. Returns false if it is
// implausible. Only after a stall (kUsualGap_ns) is a larger motion plausible.
bool WoodenHaptics::addMotion(const WoodenReport& report) noexcept {
    ArmCounts turned{};
    for (std::size_t i = 0; i < 6; ++i)
        turned[i] = std::int16_t(std::uint16_t(report.encoders[i]) - std::uint16_t(raw_[i]));
    if (stall_ns_ > 0 && ++reports_since_stall_ > kReportsOnTheWay) stall_ns_ = 0;
    const double limits = 1.0 + std::min(1e-9 * double(stall_ns_) / kStallUnit_s, kMaxStall);
    const Vec3 turned_rad = armAngles_rad(model_, turned);
    for (int i = 0; i < 3; ++i)
        if (std::fabs(turned_rad[i]) > limits * kMaxTurn_rad) return false;
    for (std::size_t i = 3; i < 6 && model_.hasWrist(); ++i) {
        // Counts per turn are indexed by body, counts by encoder, and the two run in opposite order.
        const double turns = turned[i] / model_.counts_per_turn[8 - i];
        if (std::fabs(turns) * 2.0 * std::numbers::pi > limits * kMaxWristTurn_rad) return false;
    }
    raw_ = report.encoders;
    for (std::size_t i = 0; i < 6; ++i)
        counts_[i] += turned[i];
    return true;
}

}  // namespace stylet::haptics
