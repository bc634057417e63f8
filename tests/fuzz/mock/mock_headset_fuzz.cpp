#include <cstddef>
#include <cstdint>
#include <fstream>

#include "tests/fuzz/mock/mock_runtime.h"

// The input is a headset file named by a scenario of the mock runtime. The runtime either accepts it or
// fails xrCreateInstance.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path file = mock_fuzz::scratchFile("headset.json"),
                                       scenario = mock_fuzz::scratchFile("scenario.json");
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    std::ofstream(scenario) << R"({"version": 2, "headset": ")" << file.string() << R"("})";
    setenv("XRMOCK_SCENARIO", scenario.c_str(), 1);
    XrInstance instance = XR_NULL_HANDLE;
    const XrResult result = mock_fuzz::createInstance(&instance);
    if (result == XR_ERROR_RUNTIME_FAILURE) return 0;
    if (result != XR_SUCCESS) std::abort();
    mock_fuzz::poll(instance);
    mock_fuzz::destroyInstance(instance);
    return 0;
}
