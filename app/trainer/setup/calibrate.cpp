#include "app/trainer/setup/calibrate.h"

#include <cstdio>

#include "app/trainer/hands/live_hand.h"
#include "app/trainer/stores/console.h"
#include "app/trainer/stores/platform_linux.h"
#include "haptics/devices/falcon/calibrate.h"
#include "patient/patient.h"

namespace stylet::trainer {

namespace {

void printPrompt(const std::string& text) {
    printResult("{}\n", text);
    std::fflush(stdout);
}

// Reads typed numbers, one per line. Asks again after a line that is not a number.
class Typed {
  public:
    std::optional<double> number() {
        if (!hasLine()) ended_ = !readTyped(waiting_);
        const std::optional<std::string> line = popLine(waiting_);
        if (!line) return std::nullopt;
        const std::optional<double> value = parseNumber<double>(*line);
        if (!value) printPrompt("Enter a number.");
        return value;
    }
    bool ended() const { return ended_ && !hasLine(); }

  private:
    bool hasLine() const { return waiting_.find('\n') != std::string::npos; }

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
    const std::unique_ptr<LiveDevice> live = openReadyDevice("falcon", plain, clock);
    const std::string refused = requestRealTime();
    if (!refused.empty()) printMessage(refused);
    Typed typed;
    const haptics::falcon::CalibrationPrompts prompts{printPrompt, [&] { return typed.number(); },
                                                      [&] { return interrupted() || typed.ended(); }};
    haptics::falcon::saveCalibration(file, haptics::falcon::calibrate(live->bare(), clock, prompts));
    printResult("Wrote {}. Use it with --calibration.\n", file.string());
}

}  // namespace stylet::trainer
