#include <cstdint>

#include "app/records/record.h"
#include "tests/fuzz/parser_target.h"

// The result is whole frames or a DataError. Only inputs covered by a checkpoint are accepted.
// HZ-RECORD-07, HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet;
    records::Record record;
    records::parseInputs(fuzz::bytesOf(input), "fuzz.bin", record);
    const std::uint64_t covered = record.checkpoints.empty() ? 0 : record.checkpoints.back().ticks;
    if (covered != record.inputs.size() || record.torn_bytes > input.size()) std::abort();
}
