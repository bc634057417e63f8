#include <cmath>

#include "app/modeller/motion/motion_fit.h"
#include "tests/fuzz/parser_target.h"

// The result is one surrogate for each of three phases, or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet;
    const auto signal = modeller::parsePhaseSignal(input, "fuzz.csv", 3);
    if (signal.size() != 3) std::abort();
    for (const patient::Surrogate& s : signal)
        if (!std::isfinite(s.v + s.rate_per_s)) std::abort();
}
