#include <cstddef>
#include <cstdint>
#include <string_view>

#include "patient/package/package_toml.h"

// A force table or a DataError; anything else is a bug.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::patient;
    if (size > kMaxTomlBytes) return 0;  // refused before it is parsed
    try {
        parseTissueDefaults("fuzz.toml", {reinterpret_cast<const char*>(data), size});
    } catch (const DataError&) {
    }
    return 0;
}
