#include <cstddef>

#include "app/records/samples.h"
#include "tests/fuzz/parser_target.h"

// The result is whole frames with ascending ticks, or a DataError.
// HZ-RECORD-07, HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet;
    const records::Samples samples = records::parseSamples(fuzz::bytesOf(input), "fuzz.bin");
    if (samples.torn_bytes > input.size()) std::abort();
    for (std::size_t i = 1; i < samples.samples.size(); ++i)
        if (samples.samples[i].tick <= samples.samples[i - 1].tick) std::abort();
}
