#include <cstddef>
#include <cstdint>
#include <fstream>

#include "tests/fuzz/mock/mock_runtime.h"

namespace {

void write(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
}

void live(const char* scenario) {
    setenv("XRMOCK_SCENARIO", scenario, 1);
    XrInstance instance = XR_NULL_HANDLE;
    const XrResult result = mock_fuzz::createInstance(&instance);
    if (result == XR_ERROR_RUNTIME_FAILURE) return;
    if (result != XR_SUCCESS) std::abort();
    for (int i = 0; i < 4; ++i)
        mock_fuzz::poll(instance);
    mock_fuzz::destroyInstance(instance);
}

}  // namespace

// The input is a recording of a head or of a hand's joints, named by a scenario of the mock runtime. The
// runtime either accepts it or fails xrCreateInstance.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path csv = mock_fuzz::scratchFile("recording.csv"),
                                       head = mock_fuzz::scratchFile("head.json"),
                                       hand = mock_fuzz::scratchFile("hand.json");
    static const bool written = [] {
        write(head, R"({"version": 2, "head": {"csv": "recording.csv"}})");
        write(hand, R"({"version": 2, "hands": {"left": {"joints": {"csv": "recording.csv"}}}})");
        return true;
    }();
    if (!written) std::abort();
    write(csv, std::string(reinterpret_cast<const char*>(data), size));
    live(head.c_str());
    live(hand.c_str());
    return 0;
}
