#include <cstddef>
#include <cstdint>
#include <string_view>

#include "patient/package/package_toml.h"

// The result is a force table or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::patient;
    if (size > kMaxTomlBytes) return 0;  // rejected before parsing
    try {
        parseTissueDefaults("fuzz.toml", {reinterpret_cast<const char*>(data), size});
    } catch (const stylet::DataError&) {
    }
    return 0;
}
