#include "haptics/devices/falcon/falcon_firmware.h"

#include <algorithm>
#include <initializer_list>
#include <iterator>

#include "base/whole_file.h"
#include "haptics/devices/falcon/sha256.h"
#include "patient/patient.h"

namespace stylet::haptics::falcon {

namespace {

constexpr std::size_t kMaxFirmwareBytes = 64 * 1024;
constexpr std::size_t kChunkBytes = 62;  // 62 as in the source's code; its comments say 58 and 128
constexpr int kMaxGreetings = 100;
constexpr int kLoaderWait_ms = 20;  // longer than the chip's 16 ms between answers
constexpr std::int64_t kGreeting_ns = 50'000'000, kEcho_ns = 80'000'000;

constexpr std::uint8_t kGreeting[] = {0x0A, 0x43, 0x0D};
constexpr std::uint8_t kGreetingReply[] = {0x0A, 0x44, 0x2C, 0x0D};  // macOS puts a zero before it
constexpr std::uint8_t kBeginLoad[] = {0x41};

struct Setting {
    FtdiRequest request;
    std::uint16_t value;
};

BusResult set(FtdiBus& bus, std::initializer_list<Setting> settings, std::string& why) {
    for (const Setting& s : settings)
        if (const BusResult result = bus.control(s.request, s.value, why); result != BusResult::ok)
            return result;
    return BusResult::ok;
}

FirmwareLoader::Outcome toOutcome(BusResult result, std::string& why, const char* what) {
    if (result == BusResult::ok) return FirmwareLoader::Outcome::inProgress;
    if (result == BusResult::lost) return FirmwareLoader::Outcome::lost;
    if (why.empty()) why = what;
    return FirmwareLoader::Outcome::failed;
}

}  // namespace

Firmware loadFirmwareFile(const std::filesystem::path& file) {
    const std::string bytes = readWholeFile(file, kMaxFirmwareBytes);
    if (bytes.empty()) throw DataError(file, "firmware", "empty");
    Firmware firmware;
    firmware.image.assign(bytes.begin(), bytes.end());
    firmware.sha256 = computeSha256(firmware.image);
    return firmware;
}

BusResult setNormalMode(FtdiBus& bus, std::string& why) {
    // Divisor 2: about 1.5 Mbaud (unproven).
    return set(
        bus,
        {{kFtdiLatency, 1}, {kFtdiBaud, 0x0002}, {kFtdiReset, kPurgeReceived}, {kFtdiReset, kPurgeToSend}},
        why);
}

void FirmwareLoader::begin() noexcept {
    part_ = Part::greeting;
    greetings_ = 0;
    sent_ = 0;
}

FirmwareLoader::Outcome FirmwareLoader::step(const std::vector<std::uint8_t>& image, std::string& why) {
    switch (part_) {
        case Part::greeting:
            return greet(why);
        case Part::rate:
            return changeRate(why);
        case Part::image:
            return sendChunk(image, why);
    }
    return Outcome::failed;
}

// Uses 9600 baud and a latency of 16 ms; libnifalcon warns that "otherwise firmware checks tend to fail".
FirmwareLoader::Outcome FirmwareLoader::greet(std::string& why) {
    BusResult result = set(*bus_,
                           {{kFtdiReset, kPurgeReceived},
                            {kFtdiReset, kPurgeToSend},
                            {kFtdiLatency, 16},
                            {kFtdiBaud, 0x4138},
                            {kFtdiLine, 8},
                            {kFtdiFlow, 0},
                            {kFtdiModem, 0x0200},
                            {kFtdiModem, 0x0100},
                            {kFtdiModem, 0x0101}},
                           why);
    if (result == BusResult::ok) result = bus_->write(kGreeting, kLoaderWait_ms, why);
    if (result == BusResult::ok) result = expect(kGreetingReply, kGreeting_ns, why);
    if (result == BusResult::ok) part_ = Part::rate;
    if (result == BusResult::late && ++greetings_ < kMaxGreetings) return Outcome::inProgress;
    return toOutcome(result, why, "the Falcon's firmware loader does not answer");
}

FirmwareLoader::Outcome FirmwareLoader::changeRate(std::string& why) {
    BusResult result = set(*bus_, {{kFtdiModem, 0x0100}, {kFtdiBaud, 0x0015}}, why);
    if (result == BusResult::ok) result = bus_->write(kBeginLoad, kLoaderWait_ms, why);
    if (result == BusResult::ok) result = expect(kBeginLoad, kEcho_ns, why);
    if (result == BusResult::ok) part_ = Part::image;
    return toOutcome(result, why, "the Falcon's firmware loader did not accept the faster rate");
}

// The echo serves as checksum. Without an answer the chip still sends its status, so only a deadline ends
// the wait.
FirmwareLoader::Outcome FirmwareLoader::sendChunk(const std::vector<std::uint8_t>& image, std::string& why) {
    const std::size_t count = std::min(kChunkBytes, image.size() - sent_);
    const std::span<const std::uint8_t> chunk(image.data() + sent_, count);
    BusResult result = bus_->write(chunk, kLoaderWait_ms, why);
    if (result == BusResult::ok) result = expect(chunk, kEcho_ns, why);
    if (result != BusResult::ok)
        return toOutcome(result, why, "the Falcon did not echo a piece of its firmware correctly");
    sent_ += count;
    if (sent_ < image.size()) return Outcome::inProgress;
    result = setNormalMode(*bus_, why);
    return result == BusResult::ok ? Outcome::done
                                   : toOutcome(result, why, "the Falcon's FTDI chip could not be configured");
}

// Returns ok if `bytes` arrive as one contiguous sequence within the time.
BusResult FirmwareLoader::expect(std::span<const std::uint8_t> bytes, std::int64_t within_ns,
                                 std::string& why) {
    const std::int64_t begin_ns = clock_.now();
    std::vector<std::uint8_t> seen;
    // The number of turns is limited too, because the clock may be set back meanwhile.
    for (int turn = 0; turn < 100 && clock_.now() - begin_ns < within_ns; ++turn) {
        BusBytes got;
        const BusResult result = bus_->read(got, kLoaderWait_ms, why);
        if (result == BusResult::lost) return result;
        seen.insert(seen.end(), got.bytes.begin(), got.bytes.begin() + std::ptrdiff_t(got.count));
        if (std::search(seen.begin(), seen.end(), bytes.begin(), bytes.end()) != seen.end())
            return BusResult::ok;
    }
    return BusResult::late;
}

}  // namespace stylet::haptics::falcon
