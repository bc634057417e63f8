#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "render/gpu/pipeline_cache_file.h"

// The driver only receives complete data that was sealed by this program. Any bytes can be sealed.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::render;
    const std::span<const std::uint8_t> file(data, size), inside = cacheIn(file);
    if (!inside.empty() && !std::ranges::equal(sealedCache(inside), file)) std::abort();
    const std::vector<std::uint8_t> sealed = sealedCache(file);
    if (!std::ranges::equal(cacheIn(sealed), file)) std::abort();
    return 0;
}
