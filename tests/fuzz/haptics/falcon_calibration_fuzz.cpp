#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "haptics/devices/falcon/falcon_calibration.h"
#include "patient/patient.h"

// The result is a calibration within its range or a DataError.
// HZ-FORCE-22, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    try {
        const haptics::falcon::Calibration c =
            haptics::falcon::parseCalibration({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
        for (int i = 0; i < 3; ++i)
            if (!(c.measured_per_asked[i] >= 0.1 && c.measured_per_asked[i] <= 10.0)) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
