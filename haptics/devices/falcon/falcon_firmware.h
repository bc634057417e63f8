// The Falcon loses its firmware at power-off. The image belongs to its vendor and may not be redistributed:
// the user names a file, and the record stores its SHA-256.
//
// Facts from libnifalcon's FalconCommLibUSB.cpp and FalconFirmware.cpp, and its issues 24, 32, 33, 45, 67
// (loading often fails at first).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "haptics/devices/falcon/ftdi_bus.h"
#include "haptics/loop/loop.h"

namespace stylet::haptics::falcon {

struct Firmware {
    std::vector<std::uint8_t> image;  // empty: no file was given
    std::string sha256;
};
// Throws DataError. At most 64 KiB (the known images have 7 to 9).
Firmware loadFirmwareFile(const std::filesystem::path&);

// Configures the chip for the running firmware.
BusResult setNormalMode(FtdiBus&, std::string& why);

// Loads an image in steps, so that no call blocks for long: a greeting may take 250 ms, any other step 100
// ms.
class FirmwareLoader {
  public:
    enum class Outcome : std::uint8_t { inProgress, done, failed, lost };

    FirmwareLoader(FtdiBus& bus, const Clock& clock) : bus_(&bus), clock_(clock) {}
    void begin() noexcept;
    // Performs the next step: a greeting, the change of baud rate, or one chunk and its echo.
    Outcome step(const std::vector<std::uint8_t>& image, std::string& why);
    std::size_t sentBytes() const noexcept { return sent_; }

  private:
    enum class Part : std::uint8_t { greeting, rate, image };
    Outcome greet(std::string& why);
    Outcome changeRate(std::string& why);
    Outcome sendChunk(const std::vector<std::uint8_t>& image, std::string& why);
    BusResult expect(std::span<const std::uint8_t> bytes, std::int64_t within_ns, std::string& why);

    FtdiBus* bus_;
    Clock clock_;
    Part part_ = Part::greeting;
    int greetings_ = 0;
    std::size_t sent_ = 0;
};

}  // namespace stylet::haptics::falcon
