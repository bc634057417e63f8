#include "tests/fuzz/mock/mock_runtime.h"

// The runtime either accepts a scenario file or fails xrCreateInstance. An accepted scenario can be played.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path file = mock_fuzz::scratchFile("scenario.json");
    mock_fuzz::writeBytes(file, data, size);
    mock_fuzz::play(file);
    return 0;
}
