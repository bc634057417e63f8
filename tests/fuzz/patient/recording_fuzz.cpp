#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "patient/motion/recording.h"
#include "patient/patient.h"

// The result is a recording or a DataError. An accepted recording can be played, and its signal stays
// within bounds.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::patient;
    RecordedBreath recorded;
    try {
        recorded = parseRecordedBreath({reinterpret_cast<const char*>(data), size}, "fuzz.csv");
    } catch (const stylet::DataError&) {
        return 0;
    }
    BreathPlan plan;
    plan.recording_v = recorded.v;
    plan.recording_dt_s = recorded.dt_s;
    if (!isValidPlan(plan) || !(recorded.period_s > 0.0) || !std::isfinite(recorded.travel_m)) std::abort();
    BreathingState state;
    for (int tick = 0; tick < 2000; ++tick) {
        if (tick % 700 == 300) commandHold(state, !state.hold_wanted);
        stepBreathing(state, plan, 0.01);
        const Surrogate now = surrogateAt(state, plan, 0.01);
        if (!(std::fabs(now.v) < 100.0) || !std::isfinite(now.rate_per_s)) std::abort();
    }
    return 0;
}
