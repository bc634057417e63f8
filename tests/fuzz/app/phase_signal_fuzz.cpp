#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "app/modeller/motion/motion_fit.h"

// The result is one surrogate for each of three phases, or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    try {
        const auto signal =
            modeller::parsePhaseSignal({reinterpret_cast<const char*>(data), size}, "fuzz.csv", 3);
        if (signal.size() != 3) std::abort();
        for (const patient::Surrogate& s : signal)
            if (!std::isfinite(s.v + s.rate_per_s)) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
