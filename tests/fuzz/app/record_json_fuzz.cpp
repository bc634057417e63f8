#include <cstddef>
#include <cstdint>

#include "app/records/record.h"

// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        (void)stylet::records::parseInfo({reinterpret_cast<const char*>(data), size}, "fuzz.json");
    } catch (const stylet::DataError&) {
    }
    return 0;
}
