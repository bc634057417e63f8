#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "patient/package/package_toml.h"

// The result is a package or a DataError. An accepted package survives a write and parse round trip.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::patient;
    if (size > kMaxTomlBytes) return 0;  // rejected before parsing
    try {
        const Package p = parsePackageToml("fuzz.toml", {reinterpret_cast<const char*>(data), size});
        const std::string text = packageToml(p);
        if (packageToml(parsePackageToml("fuzz.toml", text)) != text) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
