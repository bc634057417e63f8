#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "app/records/record.h"

// The result is whole frames or a DataError. Only inputs covered by a checkpoint are accepted.
// HZ-RECORD-07, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    records::Record record;
    try {
        records::parseInputs({data, size}, "fuzz.bin", record);
        const std::uint64_t covered = record.checkpoints.empty() ? 0 : record.checkpoints.back().ticks;
        if (covered != record.inputs.size() || record.torn_bytes > size) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
