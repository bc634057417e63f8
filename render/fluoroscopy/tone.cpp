#include "render/fluoroscopy/tone.h"

#include <algorithm>

namespace stylet::render {
namespace {

// Replaces each value of a line by the mean of the open ones (>= 0) among its 2 * reach + 1 neighbours; -1 if
// none is open.
void smoothLine(const float* from, float* to, int count, int stride, int reach) {
    for (int i = 0; i < count; ++i) {
        float sum = 0.0f, weight = 0.0f;
        for (int k = std::max(0, i - reach); k <= std::min(count - 1, i + reach); ++k) {
            const float value = from[k * stride];
            if (value >= 0.0f) sum += value, weight += 1.0f;
        }
        to[i * stride] = weight > 0.0f ? sum / weight : -1.0f;
    }
}

}  // namespace

void smoothOpen(std::span<float> lattice, int side, std::span<float> scratch) {
    const int reach = std::max(1, side / 8);
    for (int pass = 0; pass < 2; ++pass) {
        for (int row = 0; row < side; ++row)
            smoothLine(&lattice[std::size_t(row * side)], &scratch[std::size_t(row * side)], side, 1, reach);
        for (int column = 0; column < side; ++column)
            smoothLine(&scratch[std::size_t(column)], &lattice[std::size_t(column)], side, side, reach);
    }
    for (float& value : lattice)
        value = std::max(value, 0.0f);
}

}  // namespace stylet::render
