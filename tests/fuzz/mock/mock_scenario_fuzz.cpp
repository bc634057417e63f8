#include <cstddef>
#include <cstdint>
#include <fstream>

#include "tests/fuzz/mock/mock_runtime.h"

// The runtime either accepts a scenario file or fails xrCreateInstance. An accepted scenario can be played.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path file = mock_fuzz::scratchFile("scenario.json");
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    setenv("XRMOCK_SCENARIO", file.c_str(), 1);
    XrInstance instance = XR_NULL_HANDLE;
    const XrResult result = mock_fuzz::createInstance(&instance);
    if (result == XR_ERROR_RUNTIME_FAILURE) return 0;
    if (result != XR_SUCCESS) std::abort();
    for (int i = 0; i < 4; ++i) {
        const XrResult polled = mock_fuzz::poll(instance);
        // A scenario may make xrPollEvent fail, but the only success codes are these two.
        if (polled > 0 && polled != XR_EVENT_UNAVAILABLE) std::abort();
    }
    mock_fuzz::destroyInstance(instance);
    return 0;
}
