#include <cstddef>
#include <cstdint>
#include <string_view>

#include "patient/planning/paths_json.h"

// The result is a list of paths or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        stylet::patient::parsePaths("fuzz.json", {reinterpret_cast<const char*>(data), size});
    } catch (const stylet::DataError&) {
    }
    return 0;
}
