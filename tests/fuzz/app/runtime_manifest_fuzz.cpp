#include <cstddef>
#include <cstdint>
#include <string_view>

#include "app/trainer/display/runtime_manifest.h"

// The result is a library name or nothing.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    stylet::trainer::readLibraryPath(std::string_view(reinterpret_cast<const char*>(data), size));
    return 0;
}
