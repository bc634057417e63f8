#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "app/training/difficulty.h"
#include "base/errors.h"

// The result is a table or a DataError. No difficulty in a table allows what an easier one forbids.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::training;
    try {
        const DifficultyTable table =
            parseDifficulties({reinterpret_cast<const char*>(data), size}, "fuzz.toml");
        if (table[Difficulty::exam].path && !table[Difficulty::guided].path) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
