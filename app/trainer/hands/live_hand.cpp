#include "app/trainer/hands/live_hand.h"

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <algorithm>

#include "app/trainer/hands/controller_hand.h"
#include "app/trainer/hands/mouse_hand.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "base/text.h"

namespace stylet::trainer {

const UserButtons kControllerFunctions{.rearm = 0,
                                       .next = 1u << 1,
                                       .breath = 1u << 2,
                                       .pedal = 1u << 3,
                                       .inject = 1u << 4,
                                       .aspirate = 1u << 5,
                                       .snap = kSnapButton,
                                       .expert = 1u << 6};

namespace {

constexpr std::int64_t kLook_ns = 20'000'000;
constexpr std::int64_t kLookAgain_ns = 250'000'000;  // while the device is absent

void requestRealTimeSilently() {
    requestRealTime();  // the loop's thread reports the same failure
}

}  // namespace

LiveDevice::LiveDevice(const std::string& kind, const haptics::DeviceOptions& options,
                       const haptics::Clock& clock)
    : LiveDevice(kind, haptics::makeDriver(kind, options, clock), clock) {}

LiveDevice::LiveDevice(const std::string& kind, std::unique_ptr<haptics::Driver> driver,
                       const haptics::Clock& clock)
    : kind_(kind),
      clock_(clock),
      device_(std::move(driver), clock,
              haptics::PolledSettings{
                  .absent_retry_ns = kLookAgain_ns,
                  // Not for controllers: their thread waits for the OpenXR runtime's locks, and a real-time
                  // thread must not wait.
                  .atThreadStart = kind == kControllers ? nullptr : requestRealTimeSilently}) {
    device_.start();
}

std::unique_ptr<LiveDevice> openReadyDevice(const std::string& kind, const haptics::DeviceOptions& options,
                                            const haptics::Clock& clock) {
    auto live = std::make_unique<LiveDevice>(kind, options, clock);
    if (!live->waitUntilReady(interrupted))
        throw DataError(kind, "device", "stopped before the device was ready");
    return live;
}

void checkDeviceName(const std::string& name, std::initializer_list<const char*> others) {
    std::vector<std::string> names(others.begin(), others.end());
    for (const haptics::DeviceKind& kind : haptics::deviceKinds())
        names.emplace_back(kind.name);
    if (std::find(names.begin(), names.end(), name) == names.end())
        throw DataError(name, "device", fmt::format("not among: {}", fmt::join(names, ", ")));
}

void checkTraceOption(const std::string& kind, const std::filesystem::path& trace) {
    if (kind == kReplayDevice && trace.empty())
        throw UsageError("--device replay needs --trace with the CSV file of the recorded input");
    if (kind != kReplayDevice && !trace.empty())
        throw UsageError("--trace: only with --device replay, not with " + kind);
}

bool LiveDevice::waitUntilReady(const std::function<bool()>& given_up) {
    while (device_.stage() != haptics::DeviceStage::ready) {
        reportStateChanges();
        if (given_up()) return false;
        clock_.sleepUntil_ns(clock_.context, clock_.now_ns(clock_.context) + kLook_ns);
    }
    reportStateChanges();
    return true;
}

Pose LiveDevice::grip() {
    return device_.read(clock_.now_ns(clock_.context)).device_from_stylus;
}

UserButtons LiveDevice::buttons() const {
    // The Falcon's third button is its clutch. Among the other devices, only those that sense no orientation
    // have a clutch: the first button.
    if (kind_ == "falcon") return {.rearm = 1u << 0, .next = 1u << 1, .breath = 1u << 3};
    if (kind_ == kMouse) return {.rearm = 0};  // it has keys (window_keys.h)
    if (kind_ == kControllers) return kControllerFunctions;
    const std::uint32_t first = clutched_ || !exertsForce() ? 0u : 1u << 0;
    return {.rearm = first, .next = 1u << 1, .regrip = first, .breath = 1u << 2};
}

std::string LiveDevice::describeButtons(training::Course course) const {
    if (kind_ == kMouse) return "the keys are listed below the pictures";
    if (kind_ == kControllers)
        return describe(buttons(), kControllerButtons, course) +
               "; with bare hands, pinch thumb and index finger for the trigger, thumb and middle finger for "
               "menu, thumb and ring finger for squeeze";
    return describe(buttons(), {}, course);
}

std::string LiveDevice::rearmAct() const {
    if (!exertsForce()) return "";
    return buttons().rearm != 0 ? "the device's first button or Enter" : "Enter";
}

std::string LiveDevice::typed() {
    std::string text;
    typing_ = typing_ && readTyped(text);
    return text;
}

haptics::HapticDevice& LiveDevice::loopDevice(const Pose& tool_pose) {
    if (device_.profile().senses_rotation) return device_;
    // The Falcon's clutch is its centre button. Other devices use their first button.
    haptics::ClutchSettings clutch;
    if (kind_ != "falcon") clutch.button = 1u;
    return clutched_.emplace(device_, clutch, tool_pose);
}

void LiveDevice::setTool(const Pose& tool_pose) {
    if (clutched_) clutched_->setTool(tool_pose);
}

void LiveDevice::reportStateChanges() {
    const haptics::DeviceReport report = device_.report();
    std::string text(enumName(haptics::kDeviceStageNames, report.stage));
    if (!report.why.empty()) text += ": " + report.why;
    if (report.silences > 0)
        text += fmt::format(
            " (this computer was too busy to control it for 15 ms, {} times so far; the force is "
            "off)",
            report.silences);
    // On a slow computer a call takes long again and again. It is reported once for each state.
    const bool known = text == reported_state_, slow = report.blocked_ns > 0;
    if (known && (!slow || reported_slow_)) return;
    reported_slow_ = slow;
    reported_state_ = text;
    printMessage(kind_ + ": " + text + (slow ? " (it has not answered for some time)" : ""));
}

}  // namespace stylet::trainer
