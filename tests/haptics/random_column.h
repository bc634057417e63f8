// Random force tables and layers.
#pragma once

#include <cmath>
#include <random>

#include "tests/haptics/column.h"

namespace stylet::test {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
    return low + (high - low) * (double(random() >> 11) * 0x1p-53);
}
inline int below(Random& random, int n) {
    return int(random() % std::uint64_t(n));
}

inline patient::TissueTable randomTable(Random& random) {
    patient::TissueTable table{};
    for (int t = 1; t < patient::kTissueCount; ++t) {
        patient::TissueRow& row = table[std::size_t(t)];
        row.cut_force_n = patient::Tissue(t) == patient::Tissue::bone ? HUGE_VAL : uniform(random, 0.05, 3.0);
        row.friction_n = uniform(random, 0.05, 2.0);
        row.stiffness_n_per_m = uniform(random, 300.0, 3000.0);
        row.membrane = below(random, 3) == 0;
    }
    return table;
}

inline Layers randomLayers(Random& random) {
    Layers layers;
    for (int i = 0; i < 14; ++i) {
        // Keep bone rare, because a needle cannot pass through it.
        patient::Tissue t = patient::Tissue(below(random, patient::kTissueCount));
        if (t == patient::Tissue::bone && below(random, 4) != 0) t = patient::Tissue::liver;
        const int voxels = below(random, 3) == 0 ? 1 + below(random, 8) : 5 + below(random, 50);
        layers.push_back({t, 0.0001 * voxels});
    }
    layers.push_back({patient::Tissue::soft, 0.01});
    return layers;
}

// A scripted hand on a column of random layers.
struct RandomColumn {
    explicit RandomColumn(std::uint64_t seed) : random(seed), package(makeColumn(randomLayers(random))) {
        package.tissues = randomTable(random);
    }
    Random random;
    patient::Package package;
    patient::Patient patient{package};
    Hand hand{patient};
};

}  // namespace stylet::test
