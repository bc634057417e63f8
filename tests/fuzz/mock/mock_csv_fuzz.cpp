#include "tests/fuzz/mock/mock_runtime.h"

// The input is a recording of a head or of a hand's joints, named by a scenario of the mock runtime. The
// runtime either accepts it or fails xrCreateInstance.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::filesystem::path csv = mock_fuzz::scratchFile("recording.csv"),
                                       head = mock_fuzz::scratchFile("head.json"),
                                       hand = mock_fuzz::scratchFile("hand.json");
    static const bool written = [] {
        std::ofstream(head) << R"({"version": 2, "head": {"csv": "recording.csv"}})";
        std::ofstream(hand) << R"({"version": 2, "hands": {"left": {"joints": {"csv": "recording.csv"}}}})";
        return true;
    }();
    if (!written) std::abort();
    mock_fuzz::writeBytes(csv, data, size);
    mock_fuzz::play(head);
    mock_fuzz::play(hand);
    return 0;
}
