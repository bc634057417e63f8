#include <cstddef>
#include <cstdint>
#include <string_view>

#include "haptics/devices/replay.h"
#include "patient/patient.h"

// The result is a trace or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        stylet::haptics::parseTrace("fuzz.csv", {reinterpret_cast<const char*>(data), size});
    } catch (const stylet::DataError&) {
    }
    return 0;
}
