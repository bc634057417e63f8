#include "app/trainer/setup/calibrate.h"

#include <cstdio>
#include <cstdlib>

#include "app/trainer/hands/live_hand.h"
#include "app/trainer/stores/platform_linux.h"
#include "haptics/devices/falcon/calibrate.h"
#include "patient/patient.h"

namespace stylet::trainer {

namespace {

// Reads typed numbers, one per line. Asks again after a line that is not a number.
class Typed {
  public:
    std::optional<double> number() {
        if (waiting_.find('\n') == std::string::npos) ended_ = !takeTyped(waiting_);
        const std::size_t end = waiting_.find('\n');
        if (end == std::string::npos) return std::nullopt;
        const std::string line = waiting_.substr(0, end);
        waiting_.erase(0, end + 1);
        char* rest = nullptr;
        const double value = std::strtod(line.c_str(), &rest);
        if (rest != line.c_str() && *rest == '\0') return value;
        std::printf("Enter a number.\n");
        std::fflush(stdout);
        return std::nullopt;
    }
    bool ended() const { return ended_ && waiting_.find('\n') == std::string::npos; }

  private:
    std::string waiting_;
    bool ended_ = false;
};

}  // namespace

void calibrateFalcon(const haptics::DeviceOptions& options, const std::filesystem::path& file) {
    haptics::DeviceOptions plain = options;
    plain.calibration.clear();  // measure without an existing calibration
    haptics::falcon::checkCalibrationFile(file);
    catchInterrupts();
    const haptics::Clock clock = monotonicClock();
    LiveDevice live("falcon", plain, clock);
    if (!live.waitUntilReady(interrupted))
        throw DataError("falcon", "device", "stopped before the device was ready");
    const std::string refused = askForRealTime();
    if (!refused.empty()) std::fprintf(stderr, "stylet: %s\n", refused.c_str());
    Typed typed;
    const haptics::falcon::CalibrationTalk talk{[](const std::string& text) {
                                                    std::printf("%s\n", text.c_str());
                                                    std::fflush(stdout);
                                                },
                                                [&] { return typed.number(); },
                                                [&] { return interrupted() || typed.ended(); }};
    haptics::falcon::saveCalibration(file, haptics::falcon::calibrate(live.bare(), clock, talk));
    std::printf("Wrote %s. Use it with --calibration.\n", file.c_str());
}

}  // namespace stylet::trainer
