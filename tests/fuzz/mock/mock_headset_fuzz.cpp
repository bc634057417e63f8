#include "tests/fuzz/mock/mock_runtime.h"

// The input is a headset file named by a scenario of the mock runtime. The runtime either accepts it or
// fails xrCreateInstance.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path file = mock_fuzz::scratchFile("headset.json"),
                                       scenario = mock_fuzz::scratchFile("scenario.json");
    mock_fuzz::writeBytes(file, data, size);
    std::ofstream(scenario) << R"({"version": 2, "headset": ")" << file.string() << R"("})";
    mock_fuzz::play(scenario);
    return 0;
}
