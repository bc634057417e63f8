#include <cstddef>
#include <cstdint>
#include <string_view>

#include "haptics/devices/inverse3/service_linux.h"

// The input is the kernel's socket table as text. The search for a listener must not crash.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::haptics;
    const std::string_view table(reinterpret_cast<const char*>(data), size);
    (void)hasListener(10001, table);
    (void)hasListener("/run/user/1000/bridge.sock", table);
    return 0;
}
