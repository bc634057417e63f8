#include <cmath>

#include "app/trainer/attempt/scenario.h"
#include "tests/fuzz/parser_target.h"

// The result is a scenario or a DataError. The duration of an accepted scenario is finite.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet;
    const trainer::Scenario s = trainer::parseScenario(input, "fuzz.toml");
    double seconds = 0.0;
    for (const trainer::Stage& stage : s.stages) {
        const bool moves = stage.kind == trainer::StageKind::move;
        if (moves && !(stage.speed_m_s > 0.0)) std::abort();
        seconds += stage.seconds;
    }
    if (!std::isfinite(seconds + s.start.deeper_m + s.ramp_s)) std::abort();
}
