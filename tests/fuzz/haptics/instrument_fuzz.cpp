#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <variant>

#include "base/errors.h"
#include "haptics/tools/instrument.h"

// The result is an instrument or a DataError. A needle that is read has a valid shape.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::haptics;
    try {
        const Instrument one = parseInstrument("fuzz.toml", {reinterpret_cast<const char*>(data), size});
        if (one.kind == InstrumentKind::needle && !shapeError(one.shape).empty()) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
