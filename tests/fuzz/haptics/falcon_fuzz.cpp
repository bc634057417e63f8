#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "haptics/devices/falcon/falcon.h"

namespace {

using namespace stylet::haptics;

std::int64_t now_ns = 0;
bool homed_by_bytes = false;

// Plays the input in pieces: a length, then that many bytes from the device. Checks the host's packets.
class Bytes final : public FtdiBus {
  public:
    explicit Bytes(std::span<const std::uint8_t> left) : left_(left) {}
    DeviceStage open(std::string&) override { return DeviceStage::opening; }
    BusResult control(std::uint8_t, std::uint16_t, std::string&) override { return BusResult::ok; }
    BusResult write(std::span<const std::uint8_t> bytes, int, std::string&) override {
        if (bytes.size() != 16 || bytes[0] != '<' || bytes[15] != '>' || (bytes[13] & 1) != 0)
            std::abort();  // every packet has the homing bit
        const bool zero = std::all_of(bytes.begin() + 1, bytes.begin() + 13, [](auto b) { return b == 'A'; });
        if (!zero && !homed_by_bytes) std::abort();
        return BusResult::ok;
    }
    BusResult read(BusBytes& got, int, std::string&) override {
        now_ns += 1'000'000;
        got.count = 0;
        if (left_.empty()) return BusResult::lost;
        const std::size_t count = std::min({std::size_t(left_[0]) % 63, left_.size() - 1, got.bytes.size()});
        std::copy_n(left_.begin() + 1, count, got.bytes.begin());
        got.count = count;
        left_ = left_.subspan(count + 1);
        return BusResult::ok;
    }
    void close() noexcept override {}

  private:
    std::span<const std::uint8_t> left_;
};

}  // namespace

// Whatever the device sends, the host sends no force before the device reports that it is homed, and every
// position is within reach.
// HZ-FORCE-11, HZ-FORCE-21, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    homed_by_bytes = std::count_if(data, data + size, [](auto b) { return b >= 'A' + 0x70; }) >= 10;
    now_ns = 0;
    falcon::FalconDriver driver(std::make_unique<Bytes>(std::span(data, size)),
                                {nullptr, [](void*) noexcept { return now_ns; }, nullptr}, {});
    std::string why;
    driver.open(why);
    for (DeviceStage stage = DeviceStage::opening; stage != DeviceStage::failed;) {
        DeviceState state;
        state.fresh = 0;
        stage = driver.exchange({0.0, 1.0, 2.0}, state, why);
        const stylet::Vec3& p = state.device_from_stylus.position_m;
        if (state.fresh != 0 && !(std::fabs(p.x) < 0.3 && std::fabs(p.y) < 0.3 && std::fabs(p.z) < 0.3))
            std::abort();
        if (stage == DeviceStage::failed && why.empty()) std::abort();
    }
    return 0;
}
