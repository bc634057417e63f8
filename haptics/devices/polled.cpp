#include "haptics/devices/polled.h"

#include <algorithm>
#include <cmath>
#include <exception>

namespace stylet::haptics {

namespace {

// stop() takes effect within this time, even if the next attempt is far off.
constexpr std::int64_t kMaxSleep_ns = 20'000'000;

bool isOpen(DeviceStage stage) noexcept {
    return stage != DeviceStage::absent && stage != DeviceStage::failed;
}

bool same(double a, double b) noexcept {
    return a == b || (std::isnan(a) && std::isnan(b));
}

// Compares the values that the output stage was configured with.
bool sameLimits(const DeviceProfile& a, const DeviceProfile& b) noexcept {
    return a.force_axes == b.force_axes && same(a.force_peak_n, b.force_peak_n) &&
           same(a.force_continuous_n, b.force_continuous_n) && same(a.stiffness_n_per_m, b.stiffness_n_per_m);
}

std::int64_t pollPeriod_ns(const DeviceProfile& profile) noexcept {
    const double rate_hz = std::isnan(profile.rate_hz) ? 1000.0 : std::clamp(profile.rate_hz, 1.0, 4000.0);
    return std::llround(1e9 / rate_hz);
}

}  // namespace

PolledDevice::PolledDevice(std::unique_ptr<Driver> driver, const Clock& clock, const PolledSettings& settings)
    : driver_(std::move(driver)),
      clock_(clock),
      settings_(settings),
      first_profile_(driver_->profile()),
      profile_(first_profile_),
      retry_ns_(now()),
      backoff_ns_(settings.backoff_first_ns) {
    last_.flags = 0;
    last_.fresh = 0;
    states_.publish(last_);
}

PolledDevice::~PolledDevice() {
    stop();
}

const DeviceProfile& PolledDevice::profile() const noexcept {
    return profile_known_.load(std::memory_order_acquire) ? profile_ : first_profile_;
}

DeviceState PolledDevice::read(std::int64_t) noexcept {
    DeviceState state;
    if (!states_.read(state)) state.fresh = 0;
    if (state.fresh == 0 && isHostLate()) state.flags |= kDeviceHostLate;
    return state;
}

// Haptics thread. Wait-free. Of the time since the newest data, the part in which the device was not polled
// although it was due. Zero before the device is ready: nothing is due then.
bool PolledDevice::isHostLate() const noexcept {
    if (stage() != DeviceStage::ready) return false;
    const std::int64_t now_ns = now(), call_ns = call_ns_.load(std::memory_order_acquire);
    const std::int64_t in_call_ns = call_ns != 0 ? std::max<std::int64_t>(0, now_ns - call_ns) : 0;
    const std::int64_t polled_ns = silence_ns_.load(std::memory_order_acquire) + in_call_ns;
    return now_ns - fresh_ns_.load(std::memory_order_acquire) - polled_ns >= kHostLate_ns;
}

// The device's silence grows by the time in the driver, and by the wait for it if the exchange began about
// when it was due.
void PolledDevice::countSilence(std::int64_t begin_ns, std::int64_t end_ns, std::int64_t period_ns,
                                bool fresh) noexcept {
    const std::int64_t waited_ns = std::clamp<std::int64_t>(begin_ns - polled_ns_, 0, 2 * period_ns);
    const std::int64_t in_call_ns = std::max<std::int64_t>(0, end_ns - begin_ns);
    polled_ns_ = end_ns;
    // In this order, so that read() never sees the old time of data with the new silence.
    if (fresh) fresh_ns_.store(end_ns, std::memory_order_release);
    silence_ns_.store(fresh ? 0 : silence_ns_.load(std::memory_order_relaxed) + waited_ns + in_call_ns,
                      std::memory_order_release);
}

void PolledDevice::send(const Vec3& force_n) noexcept {
    forces_.publish(force_n);
}

void PolledDevice::start() {
    stop_.store(false);
    thread_ = std::thread([this] { run(); });
}

void PolledDevice::stop() {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
    release();
}

void PolledDevice::release() noexcept {
    if (!open_) return;
    driver_->close();
    open_ = false;
    setStage(DeviceStage::absent, "closed");
    publishLost();
}

void PolledDevice::run() noexcept {
    if (settings_.atThreadStart) settings_.atThreadStart();
    while (!stop_.load(std::memory_order_acquire)) {
        const std::int64_t due_ns = poll(), now_ns = now();
        if (due_ns > now_ns) clock_.sleepUntil(std::min(due_ns, now_ns + kMaxSleep_ns));
    }
    release();
}

std::int64_t PolledDevice::poll() noexcept {
    const std::int64_t now_ns = now();
    return open_ ? exchange(now_ns) : open(now_ns);
}

// Calls the driver and measures how long that takes. An exception becomes `failed` with a reason.
template <typename Call>
DeviceStage PolledDevice::callDriver(std::string& why, const Call& call) noexcept {
    call_ns_.store(now(), std::memory_order_relaxed);
    DeviceStage stage = DeviceStage::failed;
    try {
        stage = call();
    } catch (const std::exception& e) {
        why = e.what();
    } catch (...) {
        why = "the driver threw an object that is no exception: report this as a bug";
    }
    call_ns_.store(0, std::memory_order_relaxed);
    return stage;
}

std::int64_t PolledDevice::open(std::int64_t now_ns) {
    // If the clock was set back, wait no longer than the longest back-off.
    retry_ns_ = std::min(retry_ns_, now_ns + settings_.backoff_max_ns);
    if (now_ns < retry_ns_) return retry_ns_;
    opens_.fetch_add(1, std::memory_order_relaxed);
    std::string why;
    const DeviceStage stage = confirmReady(callDriver(why, [&] { return driver_->open(why); }), why);
    if (!isOpen(stage)) return handleLoss(stage, why);
    open_ = true;
    due_ns_ = polled_ns_ = now();
    countSilence(due_ns_, due_ns_, 0, true);
    setStage(stage, why);
    return due_ns_;
}

std::int64_t PolledDevice::exchange(std::int64_t now_ns) {
    const std::int64_t period_ns = pollPeriod_ns(driver_->profile());
    // If the call is early by more than a period, the clock was set back.
    if (now_ns < due_ns_ && due_ns_ - now_ns <= period_ns) return due_ns_;

    std::string why;
    DeviceState state{.device_from_stylus = last_.device_from_stylus, .buttons = last_.buttons, .fresh = 0};
    const Vec3 force_n = currentForce(now_ns);
    const auto call = [&] { return driver_->exchange(force_n, state, why); };
    const DeviceStage stage = confirmReady(callDriver(why, call), why);
    exchanges_.fetch_add(1, std::memory_order_relaxed);
    if (!isOpen(stage)) return handleLoss(stage, why);

    const std::int64_t after_ns = now();
    countSilence(now_ns, after_ns, period_ns, state.fresh != 0);
    setStage(stage, why);
    publish(state);
    if (stage == DeviceStage::ready && after_ns - ready_ns_ > settings_.stable_ns)
        backoff_ns_ = settings_.backoff_first_ns;
    due_ns_ += period_ns;
    if (due_ns_ < after_ns || due_ns_ > after_ns + period_ns) due_ns_ = after_ns;
    return due_ns_;
}

// Returns the force for the bus: the loop's newest force, or zero if the loop is silent or the device was
// not ready when the force was sent.
Vec3 PolledDevice::currentForce(std::int64_t now_ns) noexcept {
    if (isInputOnly(driver_->profile())) return Vec3(0.0);  // no force that a silent loop could leave on
    if (forces_.read(force_n_)) {
        last_force_ns_ = now_ns;
        silent_ = released_ = false;
    } else if (!silent_ && (now_ns - last_force_ns_ >= kForceTimeout_ns || now_ns < last_force_ns_)) {
        silent_ = released_ = true;
        if (stage() == DeviceStage::ready) silences_.fetch_add(1, std::memory_order_relaxed);
    }
    return stage() == DeviceStage::ready && !silent_ && isFinite(force_n_) ? force_n_ : Vec3(0.0);
}

// The first `ready` fixes the profile. Forces sent before it are dropped.
DeviceStage PolledDevice::confirmReady(DeviceStage stage, std::string& why) {
    if (stage != DeviceStage::ready || this->stage() == DeviceStage::ready) return stage;
    if (!profile_known_.load(std::memory_order_relaxed)) {
        profile_ = driver_->profile();
        profile_known_.store(true, std::memory_order_release);
    } else if (!sameLimits(profile_, driver_->profile())) {
        why = "a device with other limits answered; close the session and open it again";
        return DeviceStage::failed;
    }
    forces_.read(force_n_);
    silent_ = true;
    released_ = false;
    ready_ns_ = now();
    return stage;
}

// A changed flag is published even if the driver has no new data.
void PolledDevice::publish(DeviceState state) noexcept {
    if (stage() != DeviceStage::ready || released_) state.flags &= ~std::uint32_t(kDeviceReady);
    if (stage() == DeviceStage::ready && released_) state.flags |= kDeviceHostLate;
    if (state.fresh == 0 && state.flags == last_.flags) return;
    state.fresh = 1;
    last_ = state;
    states_.publish(state);
}

// Publishes the last pose with all flags cleared.
void PolledDevice::publishLost() noexcept {
    DeviceState state = last_;
    state.flags = 0;
    state.fresh = 0;
    publish(state);
}

void PolledDevice::setStage(DeviceStage stage, const std::string& why) {
    if (stage == this->stage() && why == why_) return;
    const std::lock_guard lock(report_mutex_);
    why_ = why;
    stage_.store(stage, std::memory_order_release);
}

std::int64_t PolledDevice::handleLoss(DeviceStage stage, const std::string& why) {
    const bool was_open = open_;
    if (was_open || stage == DeviceStage::failed) driver_->close();
    open_ = false;
    setStage(stage, why);
    publishLost();
    if (was_open || stage == DeviceStage::failed) failures_.fetch_add(1, std::memory_order_relaxed);
    if (stage == DeviceStage::absent) {
        retry_ns_ = now() + settings_.absent_retry_ns;
    } else {
        retry_ns_ = now() + backoff_ns_;
        backoff_ns_ = std::min(2 * backoff_ns_, settings_.backoff_max_ns);
    }
    return retry_ns_;
}

DeviceReport PolledDevice::report() const {
    DeviceReport report;
    {
        const std::lock_guard lock(report_mutex_);
        report.stage = stage();
        report.why = why_;
    }
    const std::int64_t call_ns = call_ns_.load(std::memory_order_relaxed);
    if (call_ns != 0 && now() - call_ns > kDriverDeadline_ns) report.blocked_ns = now() - call_ns;
    report.exchanges = exchanges_.load(std::memory_order_relaxed);
    report.opens = opens_.load(std::memory_order_relaxed);
    report.failures = failures_.load(std::memory_order_relaxed);
    report.silences = silences_.load(std::memory_order_relaxed);
    return report;
}

}  // namespace stylet::haptics
