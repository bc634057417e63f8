#include "haptics/devices/falcon/falcon_calibration.h"
#include "tests/fuzz/parser_target.h"

// The result is a calibration within its range or a DataError.
// HZ-FORCE-22, HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet;
    const haptics::falcon::Calibration c = haptics::falcon::parseCalibration(input, "fuzz.toml");
    for (int i = 0; i < 3; ++i)
        if (!(c.measured_per_asked[i] >= 0.1 && c.measured_per_asked[i] <= 10.0)) std::abort();
}
