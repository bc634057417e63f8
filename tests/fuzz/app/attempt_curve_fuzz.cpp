#include <cstddef>
#include <cstdint>

#include "app/report/attempt_files.h"

// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        (void)stylet::report::parseCurve({reinterpret_cast<const char*>(data), size}, "fuzz.csv");
    } catch (const stylet::DataError&) {
    }
    return 0;
}
