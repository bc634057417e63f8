#include <cstddef>
#include <cstdint>

#include "patient/package/package.h"
#include "render/ultrasound/acoustics.h"

// The result is an acoustic table or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        stylet::render::parseAcoustics("fuzz.toml", {reinterpret_cast<const char*>(data), size});
    } catch (const stylet::DataError&) {
    }
    return 0;
}
