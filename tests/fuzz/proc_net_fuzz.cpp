#include <cstddef>
#include <cstdint>
#include <string_view>

#include "haptics/devices/inverse3/service_linux.h"

// The kernel's tables of sockets, as text: a listener is found or not.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::haptics;
    const std::string_view table(reinterpret_cast<const char*>(data), size);
    (void)listensOn(10001, table);
    (void)listensOn("/run/user/1000/bridge.sock", table);
    return 0;
}
