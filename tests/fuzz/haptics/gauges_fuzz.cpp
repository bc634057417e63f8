#include <cstddef>
#include <cstdint>

#include "base/errors.h"
#include "haptics/tools/gauge.h"

// The result is a list of needles or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        stylet::haptics::parseGauges("fuzz.toml", {reinterpret_cast<const char*>(data), size});
    } catch (const stylet::DataError&) {
    }
    return 0;
}
