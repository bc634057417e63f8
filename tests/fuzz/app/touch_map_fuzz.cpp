#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "app/trainer/stores/derived.h"

// A cached touch map is validated even if its checksum is correct. An accepted map is finite, fills its
// grid and has exactly these bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet;
    const auto bytes = std::as_bytes(std::span(data, size));
    const auto map = trainer::parseTouchMap(bytes);
    if (!map) return 0;
    if (map->nodes.size() != 3 * map->grid.voxelCount()) std::abort();
    if (!std::ranges::all_of(map->nodes, [](float v) { return std::isfinite(v); })) std::abort();
    if (!std::ranges::equal(trainer::bytesOf(*map), bytes)) std::abort();
    return 0;
}
