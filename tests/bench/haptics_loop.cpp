// Runs the haptic loop in real time while lavapipe renders on every core. The runs alternate with
// cyclictest at the same priority and under the same load. cyclictest is the reference because both share
// one host: it measures the latency that the machine itself causes.
#include <atomic>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>

#include <fmt/core.h>

#include "app/trainer/stores/platform_linux.h"
#include "haptics/haptics.h"
#include "tests/bench/bench.h"
#include "tests/bench/gpu.h"
#include "tests/bench/reference_patient.h"
#include "tests/render/pictures.h"

namespace stylet::bench {
namespace {

using namespace haptics;

constexpr int kAlternations = 3;

// Simulated device: moves the needle in to a depth of 80 mm and out again, at up to 40 mm/s.
class SweepingDevice final : public HapticDevice {
  public:
    explicit SweepingDevice(const Vec3& skin_m) : skin_m_(skin_m) {}
    const DeviceProfile& profile() const noexcept override { return profile_; }
    DeviceState read(std::int64_t now_ns) noexcept STYLET_NONBLOCKING override {
        const double depth_m = 0.035 - 0.045 * std::cos(0.9 * 1e-9 * double(now_ns));
        DeviceState state;
        state.device_from_stylus = {
            Quat(0.70710678118654752, 0.0, 0.70710678118654752, 0.0),  // hub to the right
            skin_m_ - Vec3(depth_m, 0.0, 0.0)};
        return state;
    }
    void send(const Vec3&) noexcept STYLET_NONBLOCKING override {}

  private:
    Vec3 skin_m_;
    DeviceProfile profile_;
};

// The monotonic clock. Records how late each sleep wakes.
struct RecordingClock {
    Clock clock = trainer::monotonicClock();
    std::vector<double> wake_us;  // delay after the deadline
    static std::int64_t now(void* self) noexcept {
        const Clock& c = static_cast<RecordingClock*>(self)->clock;
        return c.now_ns(c.context);
    }
    static void sleepUntil(void* self, std::int64_t t_ns) noexcept {
        RecordingClock& w = *static_cast<RecordingClock*>(self);
        w.clock.sleepUntil_ns(w.clock.context, t_ns);
        if (w.wake_us.size() < w.wake_us.capacity())
            w.wake_us.push_back(1e-3 * double(w.clock.now_ns(w.clock.context) - t_ns));
    }
};

struct Punctuality {
    double share = 0.0;  // fraction of ticks whose force was sent after the next deadline
    double median_us = 0.0, p99_us = 0.0;
};

Punctuality measureOurLoop(const patient::Patient& patient, const Vec3& skin_m, double seconds) {
    Simulation simulation(patient, {});
    SweepingDevice device(skin_m);
    LoopChannels channels;
    RecordingClock recording_clock;
    recording_clock.wake_us.reserve(std::size_t(seconds * 1100.0));
    std::string refused;
    LoopStats stats;
    std::thread haptics([&] {
        refused = trainer::requestRealTime();
        stats = runLoop(simulation, device, channels,
                        {&recording_clock, RecordingClock::now, RecordingClock::sleepUntil});
    });
    const auto began = std::chrono::steady_clock::now();
    TickRecord record;
    EventRecord event;
    while (elapsed_ms(began) < 1e3 * seconds) {
        while (channels.records.pop(record)) {
        }
        while (channels.events.pop(event)) {
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    channels.stop.store(true);
    haptics.join();
    if (!refused.empty()) throw std::runtime_error(refused);
    return {double(stats.late_ticks) / double(stats.ticks), quantile(recording_clock.wake_us, 0.5),
            quantile(recording_clock.wake_us, 0.99)};
}

// Runs cyclictest. A tick is late if it woke a period or more after its deadline. Throws if cyclictest
// cannot be run.
Punctuality cyclictest(double seconds) {
    const std::string command =
        fmt::format("cyclictest -q -m -t 1 -p 80 -i 1000 -D {} -h 1000 2>&1", int(seconds));
    std::FILE* pipe = popen(command.c_str(), "r");
    if (!pipe) throw std::runtime_error("cyclictest cannot be started");
    std::vector<double> counts;  // histogram of the wake-up delay, one bin per microsecond
    double total = 0.0, over = 0.0;
    char line[256];
    while (std::fgets(line, sizeof line, pipe)) {
        double us = 0.0, count = 0.0;
        if (std::sscanf(line, "# Histogram Overflows: %lf", &count) == 1)
            over = count;
        else if (std::sscanf(line, "%lf %lf", &us, &count) == 2)
            counts.push_back(count), total += count;
    }
    if (pclose(pipe) != 0 || total == 0.0) throw std::runtime_error("cyclictest failed: install rt-tests");
    total += over;
    const auto below = [&](double share) {
        double sum = 0.0;
        std::size_t us = 0;
        while (us < counts.size() && (sum += counts[us]) < share * total)
            ++us;
        return double(us);
    };
    return {over / total, below(0.5), below(0.99)};
}

// Draws both eyes without a pause until destruction.
class RenderLoad {
  public:
    explicit RenderLoad(const patient::Patient& patient)
        : gpu_({}), renderer_(gpu_, {}, test::assetsFolder()) {
        renderer_.setPatient(patient);
        const Grid& grid = patient.grid();
        scene_.stage_from_patient.position_m =
            Vec3(0.0, 1.0, 0.0) - grid.origin_m - 0.5 * grid.spacing_m * Vec3(grid.dims - 1);
        eyes_ = test::stereo(test::lookAt(Vec3(0.35, 1.35, 0.25), Vec3(0.03, 1.0, 0.0), 0.42f), 0.063);
        draw();
        thread_ = std::jthread([this](const std::stop_token& stop) {
            while (!stop.stop_requested())
                draw();
        });
    }

  private:
    void draw() {
        scene_.breath.v = scene_.breath.v < 1.0 ? scene_.breath.v + 0.01 : 0.0;
        renderer_.drawToImages(scene_, eyes_, 640, 640);
    }
    render::Gpu gpu_;
    render::Renderer renderer_;
    render::RenderScene scene_;
    std::array<render::View, 2> eyes_;
    std::jthread thread_;
};

void run(std::vector<Row>& rows) {
    if (!hasGpu("haptics.loop")) return;
    const double seconds = isLongRun() ? 60.0 : 10.0;
    const patient::Package package = referencePatient(0.002);
    const patient::Patient patient(package);
    const Grid& grid = patient.grid();
    Vec3 skin_m = grid.centre({grid.dims.x - 1, grid.dims.y / 2, grid.dims.z / 2});
    while (patient.at(skin_m, {}).tissue == Tissue::air && skin_m.x > grid.origin_m.x)
        skin_m.x -= 0.0005;

    const RenderLoad load(patient);
    for (int i = 1; i <= kAlternations; ++i) {
        const Punctuality ours = measureOurLoop(patient, skin_m, seconds), theirs = cyclictest(seconds);
        const std::string note = fmt::format(
            "late: {:.3f} %, cyclictest {:.3f} %; woken after {:.0f} us (p99 {:.0f}), cyclictest {:.0f} (p99 "
            "{:.0f})",
            1e2 * ours.share, 1e2 * theirs.share, ours.median_us, ours.p99_us, theirs.median_us,
            theirs.p99_us);
        rows.push_back({"haptics.loop", "alternation", double(i), 1e-3 * ours.median_us, 1e2 * ours.share,
                        "% late", "cyclictest, same priority, while lavapipe renders", note});
    }
}

const Registration registration("haptics.loop", run);

}  // namespace
}  // namespace stylet::bench
