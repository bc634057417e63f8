#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "app/trainer/attempt/scenario.h"
#include "patient/patient.h"

// The result is a scenario or a DataError. The duration of an accepted scenario is finite.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    try {
        const trainer::Scenario s =
            trainer::parseScenario({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
        double seconds = 0.0;
        for (const trainer::Stage& stage : s.stages) {
            const bool moves = stage.kind == trainer::StageKind::move;
            if (moves && !(stage.speed_m_s > 0.0)) std::abort();
            seconds += stage.seconds;
        }
        if (!std::isfinite(seconds + s.start.deeper_m + s.ramp_s)) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
