// Round-trip time of a device behind a socket: from sending the force to receiving the state that answers
// it.
#include <chrono>
#include <thread>

#include <fmt/core.h>

#include "haptics/devices/bridge/bridge.h"
#include "tests/bench/bench.h"
#include "tests/support/bridge_emulator.h"
#include "tests/support/temp_folder.h"
#ifdef STYLET_INVERSE3
#include "haptics/devices/inverse3/inverse3.h"
#include "tests/support/inverse3_emulator.h"
#include "tests/support/wall_clock.h"
#endif

namespace stylet::bench {
namespace {

using namespace haptics;

// Exchanges at `rate_hz` for ten seconds. The emulator is a thread of this process.
void measure(std::vector<Row>& rows, const char* name, Driver& driver, int rate_hz) {
    std::string why;
    std::vector<double> times_us;
    const int count = 10 * rate_hz;
    int stale = 0, lost = 0;
    DeviceStage stage = driver.open(why);
    auto due = std::chrono::steady_clock::now();
    for (int i = 0; i < count && stage != DeviceStage::failed && stage != DeviceStage::absent; ++i) {
        DeviceState state;
        const auto began = std::chrono::steady_clock::now();
        stage = driver.exchange({0.0, 0.0, 0.0}, state, why);
        times_us.push_back(1e3 * elapsed_ms(began));
        stale += state.fresh == 0;
        if (stage == DeviceStage::failed) {
            ++lost;
            stage = driver.open(why);
        }
        due += std::chrono::nanoseconds(1'000'000'000 / rate_hz);
        std::this_thread::sleep_until(due);
    }
    const std::string note = fmt::format(
        "median {:.0f} us, p99 {:.0f} us, p99.9 {:.0f} us; {} stale, {} lost of {}", median(times_us),
        quantile(times_us, 0.99), quantile(times_us, 0.999), stale, lost, times_us.size());
    rows.push_back({name, "exchanges [Hz]", double(rate_hz), 1e-3 * median(times_us),
                    quantile(times_us, 0.99), "us p99", "1,000 us of a tick", note});
}

void run(std::vector<Row>& rows) {
    const test::TempFolder folder;
    test::BridgeServer bridge(folder / "bridge.sock", {});
    BridgeDriver bridge_driver(test::kWallClock, {.socket_path = folder / "bridge.sock"});
    measure(rows, "haptics.device_round_trip.bridge", bridge_driver, 1000);
#ifdef STYLET_INVERSE3
    test::Inverse3Emulator service({});
    Inverse3Driver inverse3(test::kWallClock, {.port = service.port()});
    measure(rows, "haptics.device_round_trip.inverse3", inverse3, 1000);
#endif
}

const Registration registration("haptics.device_round_trip", run);

}  // namespace
}  // namespace stylet::bench
