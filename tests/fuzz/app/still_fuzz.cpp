#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "app/report/stills.h"
#include "patient/package/package.h"
#include "tests/fuzz/scratch_file.h"

// The result is a downscaled picture of an attempt, or a DataError.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    const std::filesystem::path file = fuzz::scratchFile("fuzz.png", data, size);
    try {
        const report::Picture small = report::loadStill(file, 16);
        if (small.width > 16 || small.bytes.empty()) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
