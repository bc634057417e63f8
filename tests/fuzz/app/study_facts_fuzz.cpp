#include <cstddef>
#include <cstdint>

#include "app/study/facts.h"
#include "patient/package/package.h"
#include "tests/fuzz/scratch_file.h"

namespace {

template <typename Read>
void readOrRefused(Read read, const std::filesystem::path& file) {
    try {
        (void)read(file);
    } catch (const stylet::DataError&) {
    }
}

}  // namespace

// The result is the facts of a pair, a plan or a run, or a DataError. A pair's facts can be written again.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::study;
    const std::filesystem::path file = fuzz::scratchFile("facts.json", data, size);
    readOrRefused(readPlanFacts, file);
    readOrRefused(readRunFacts, file);
    readOrRefused(
        [](const auto& f) {
            writeFacts(f, readFacts(f));
            return 0;
        },
        file);
    return 0;
}
