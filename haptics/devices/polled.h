// Any driver as the loop sees it: a thread of its own around its blocking calls, a state machine that finds
// the hardware again, and a watchdog that lets go when the loop falls silent.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "haptics/device.h"
#include "haptics/devices/driver.h"
#include "haptics/loop.h"
#include "haptics/rings.h"

namespace stylet::haptics {

struct PolledSettings {
    std::int64_t look_again_ns = 500'000'000;     // nothing plugged in: until the next look
    std::int64_t backoff_first_ns = 250'000'000;  // after a failure, doubled with each that follows
    std::int64_t backoff_most_ns = 8'000'000'000;
    std::int64_t sound_ns = 2'000'000'000;  // ready for so long: failures are forgotten
    void (*atThreadStart)() = nullptr;      // on the device's thread, first: app/ sets its priority
};

// The loop has sent nothing for so long: zero goes to the bus, which leaves 5 ms for it to get there within
// the 20 ms that every fault is given.
inline constexpr std::int64_t kSilence_ns = 15'000'000;

// What a user wants to know of a device.
struct DeviceReport {
    DeviceStage stage = DeviceStage::absent;
    std::string why;              // of failed, absent, or of what is waited for
    std::int64_t blocked_ns = 0;  // the driver has been in one call for so long, where past its deadline
    std::uint64_t exchanges = 0, opens = 0;
    std::uint64_t failures = 0;  // connections that failed to open or were lost
    std::uint64_t silences = 0;  // times the loop fell silent with the device ready
};

// As users read it: "absent", "needs firmware", ...
const char* nameOf(DeviceStage) noexcept;

class PolledDevice final : public HapticDevice {
  public:
    // The clock is read on the device's thread and in report(), and sleeps on the device's thread. Nothing
    // is opened before start() or poll().
    PolledDevice(std::unique_ptr<Driver>, const Clock&, const PolledSettings& = {});
    ~PolledDevice() override;  // as stop()

    // Until the device is first ready: what its driver takes it for; from then on the same for good. A
    // device that comes back with other limits is refused.
    const DeviceProfile& profile() const noexcept override;
    // Haptics thread. Wait-free. The newest state, its last pose where the device is lost; kDeviceReady
    // only while it is ready and was not let go of.
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override;
    // Haptics thread. Wait-free.
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override;

    // App. The device's thread begins; stop() ends it, after zero force and close(). It waits for the call
    // that the driver is in.
    void start();
    void stop();

    // Device's thread, or a test's that has not called start(): looks for the device, or does one exchange.
    // Returns when to be called again. Whatever the driver throws ends here, as a failure.
    std::int64_t poll() noexcept;

    DeviceStage stage() const noexcept { return stage_.load(std::memory_order_acquire); }
    DeviceReport report() const;  // any thread but haptics (locks)

  private:
    void run() noexcept;
    std::int64_t open(std::int64_t now_ns);
    std::int64_t exchange(std::int64_t now_ns);
    DeviceStage callOpen(std::string& why) noexcept;
    DeviceStage callExchange(const Vec3& force_n, DeviceState&, std::string& why) noexcept;
    Vec3 heardForce(std::int64_t now_ns) noexcept;
    DeviceStage admit(DeviceStage, std::string& why);
    void publish(DeviceState) noexcept;
    void publishLost() noexcept;
    void letGo() noexcept;
    void enter(DeviceStage, const std::string& why);
    std::int64_t lose(DeviceStage, const std::string& why);
    std::int64_t now() const noexcept { return clock_.now_ns(clock_.context); }

    std::unique_ptr<Driver> driver_;
    Clock clock_;
    PolledSettings settings_;
    DeviceProfile first_profile_, profile_;
    std::atomic<bool> profile_known_{false};

    Snapshot<Vec3> forces_;         // haptics -> device
    Snapshot<DeviceState> states_;  // device -> haptics
    std::atomic<DeviceStage> stage_{DeviceStage::absent};

    // Device's thread.
    bool open_ = false;
    Vec3 force_n_{0.0};
    std::int64_t heard_ns_ = 0, ready_ns_ = 0, retry_ns_, backoff_ns_, due_ns_ = 0;
    bool silent_ = true;   // zero goes out
    bool let_go_ = false;  // silent after having been heard: the loop is told so
    DeviceState last_;

    std::atomic<std::int64_t> call_ns_{0};  // the driver is in a call since; 0: it is not
    std::atomic<std::uint64_t> exchanges_{0}, opens_{0}, failures_{0}, silences_{0};
    mutable std::mutex report_mutex_;  // stage and reason; app and device's thread
    std::string why_;

    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace stylet::haptics
