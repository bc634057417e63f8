#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "render/gpu/pipeline_cache_file.h"

// The driver receives only complete data that this program sealed with a checksum. Any bytes can be sealed.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::render;
    const std::span<const std::uint8_t> file(data, size), inside = decodeCacheFile(file);
    if (!inside.empty() && !std::ranges::equal(encodeCacheFile(inside), file)) std::abort();
    const std::vector<std::uint8_t> sealed = encodeCacheFile(file);
    if (!std::ranges::equal(decodeCacheFile(sealed), file)) std::abort();
    return 0;
}
