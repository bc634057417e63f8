#include <cstddef>
#include <cstdint>

#include "app/study/facts.h"
#include "patient/package/package.h"
#include "tests/fuzz/scratch_file.h"

namespace {

template <typename Read>
void readOrReject(Read read, const std::filesystem::path& file) {
    try {
        (void)read(file);
    } catch (const stylet::DataError&) {
    }
}

}  // namespace

// The result is the facts of a pair, a plan or a run, or a DataError. The accepted facts of a pair can be
// written again.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::study;
    const std::filesystem::path file = fuzz::scratchFile("facts.json", data, size);
    readOrReject(readPlanFacts, file);
    readOrReject(readRunFacts, file);
    readOrReject(
        [](const auto& f) {
            writeFacts(f, readFacts(f));
            return 0;
        },
        file);
    return 0;
}
