#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "haptics/devices/falcon/falcon_firmware.h"

namespace {

using namespace stylet::haptics;

std::int64_t now_ns = 0;

// Plays the input in pieces: a length, then that many bytes from the device's boot loader. The length 64
// echoes the last piece sent, as a working boot loader does.
class Bytes final : public FtdiBus {
  public:
    explicit Bytes(std::span<const std::uint8_t> left) : left_(left) {}
    DeviceStage open(std::string&) override { return DeviceStage::opening; }
    BusResult control(std::uint8_t, std::uint16_t, std::string&) override { return BusResult::ok; }
    BusResult write(std::span<const std::uint8_t> bytes, int, std::string&) override {
        sent_.assign(bytes.begin(), bytes.end());
        return BusResult::ok;
    }
    BusResult read(BusBytes& got, int, std::string&) override {
        now_ns += 16'000'000;
        got.count = 0;
        if (left_.empty()) return BusResult::lost;
        const std::size_t length = left_[0] % 65;
        left_ = left_.subspan(1);
        const bool echoes = length == 64;
        const std::span<const std::uint8_t> from =
            echoes ? std::span<const std::uint8_t>(sent_) : left_.first(std::min(length, left_.size()));
        if (!echoes) left_ = left_.subspan(from.size());
        got.count = std::min(from.size(), got.bytes.size());
        std::copy_n(from.begin(), got.count, got.bytes.begin());
        return BusResult::ok;
    }
    void close() noexcept override {}

  private:
    std::span<const std::uint8_t> left_;
    std::vector<std::uint8_t> sent_;
};

}  // namespace

// Whatever the boot loader answers, the upload ends within a bounded number of steps. It succeeds only if
// the whole image was sent.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    now_ns = 0;
    std::vector<std::uint8_t> image(200);
    for (std::size_t i = 0; i < image.size(); ++i)
        image[i] = std::uint8_t(7 * i);
    Bytes bus(std::span(data, size));
    falcon::FirmwareLoader loader(bus, {nullptr, [](void*) noexcept { return now_ns; }, nullptr});
    loader.begin();
    std::string why;
    auto outcome = falcon::FirmwareLoader::Outcome::inProgress;
    for (int steps = 0; outcome == falcon::FirmwareLoader::Outcome::inProgress; ++steps) {
        if (steps > 200) std::abort();
        outcome = loader.step(image, why);
    }
    if (outcome == falcon::FirmwareLoader::Outcome::done && loader.sentBytes() != image.size()) std::abort();
    if (outcome == falcon::FirmwareLoader::Outcome::failed && why.empty()) std::abort();
    return 0;
}
