// Adapts any driver to the loop: a separate thread for its blocking calls, a state machine that finds the
// hardware again, and a watchdog that releases the force when the loop falls silent.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "base/rings.h"
#include "haptics/devices/driver.h"
#include "haptics/loop/loop.h"
#include "haptics/tools/device.h"

namespace stylet::haptics {

struct PolledSettings {
    std::int64_t absent_retry_ns = 500'000'000;   // absent device: interval between searches
    std::int64_t backoff_first_ns = 250'000'000;  // delay after a failure, doubled with each further one
    std::int64_t backoff_max_ns = 8'000'000'000;
    // After this time in `ready`, the next failure starts again with backoff_first_ns.
    std::int64_t stable_ns = 2'000'000'000;
    void (*atThreadStart)() = nullptr;  // called first on the device's thread: app/ sets its priority
};

// Time without a force from the haptics loop after which zero force is sent to the device. Every fault must
// lead to zero force within 20 ms, so 5 ms remain for the zero to reach the device.
inline constexpr std::int64_t kForceTimeout_ns = 15'000'000;

// A silence is blamed on this computer (kDeviceHostLate) if the device's thread ran this much too late in it.
// Half of kStaleInput_s: the larger part of a silence that is just long enough to be a fault.
inline constexpr std::int64_t kHostLate_ns = 10'000'000;

// Status of a device for the user.
struct DeviceReport {
    DeviceStage stage = DeviceStage::absent;
    std::string why;              // reason for failed or absent, or what is missing
    std::int64_t blocked_ns = 0;  // how long the driver has been in one call, if past its deadline
    std::uint64_t exchanges = 0, opens = 0;
    std::uint64_t failures = 0;  // connections that failed to open or were lost
    // Times the loop fell silent while the device was ready. Always 0 for a device without force.
    std::uint64_t silences = 0;
};

class PolledDevice final : public HapticDevice {
  public:
    // The clock's time is read on the device's thread, in read() and in report(). Its sleep function is
    // called on the device's thread. The constructor does not open the device; start() and poll() do.
    PolledDevice(std::unique_ptr<Driver>, const Clock&, const PolledSettings& = {});
    ~PolledDevice() override;  // calls stop()

    // Returns the driver's initial profile until the device is first ready. From then on the profile is
    // fixed: a device that returns with other limits is refused.
    const DeviceProfile& profile() const noexcept override;
    // Haptics thread. Wait-free. Returns the newest state, with the last pose if the device is lost.
    // kDeviceReady is set only while the device is ready and the watchdog has not released its force.
    // kDeviceHostLate is set if the watchdog has released it, and while data is missing because the device's
    // thread ran too late. A driver's call that takes long counts as the device's silence.
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override;
    // Haptics thread. Wait-free.
    void send(const Vec3& force_n) noexcept STYLET_NONBLOCKING override;

    // Called by the application. start() starts the device's thread. stop() waits for the driver's current
    // call to return, sends zero force, closes the device and ends the thread.
    void start();
    void stop();

    // Device's thread, or a test that has not called start(). Looks for the device or performs one exchange.
    // Returns the time of the next call. An exception from the driver counts as a failure.
    std::int64_t poll() noexcept;

    DeviceStage stage() const noexcept { return stage_.load(std::memory_order_acquire); }
    DeviceReport report() const;  // any thread but haptics (locks)

  private:
    void run() noexcept;
    std::int64_t open(std::int64_t now_ns);
    std::int64_t exchange(std::int64_t now_ns);
    template <typename Call>
    DeviceStage callDriver(std::string& why, const Call&) noexcept;
    Vec3 currentForce(std::int64_t now_ns) noexcept;
    void countSilence(std::int64_t begin_ns, std::int64_t end_ns, std::int64_t period_ns,
                      bool fresh) noexcept;
    bool isHostLate() const noexcept;
    DeviceStage confirmReady(DeviceStage, std::string& why);
    void publish(DeviceState) noexcept;
    void publishLost() noexcept;
    void release() noexcept;
    void setStage(DeviceStage, const std::string& why);
    std::int64_t handleLoss(DeviceStage, const std::string& why);
    std::int64_t now() const noexcept { return clock_.now(); }

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
    std::int64_t last_force_ns_ = 0, ready_ns_ = 0, retry_ns_, backoff_ns_, due_ns_ = 0;
    bool silent_ = true;     // zero is being sent
    bool released_ = false;  // the loop sent forces and then fell silent; reported to the loop
    DeviceState last_;

    std::int64_t polled_ns_ = 0;  // end of the last exchange, or of opening

    // Time of the newest data, and how long the device has been polled in time since then without new data.
    std::atomic<std::int64_t> fresh_ns_{0}, silence_ns_{0};
    std::atomic<std::int64_t> call_ns_{0};  // start of the driver's current call; 0: none
    std::atomic<std::uint64_t> exchanges_{0}, opens_{0}, failures_{0}, silences_{0};
    mutable std::mutex report_mutex_;  // guards stage and reason; app and device's thread
    std::string why_;

    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}  // namespace stylet::haptics
