#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "app/records/samples.h"
#include "patient/package/package.h"

// The result is whole frames with ascending ticks, or a DataError.
// HZ-RECORD-07, HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    try {
        const records::Samples samples = records::parseSamples({data, size}, "fuzz.bin");
        if (samples.torn_bytes > size) std::abort();
        for (std::size_t i = 1; i < samples.samples.size(); ++i)
            if (samples.samples[i].tick <= samples.samples[i - 1].tick) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
