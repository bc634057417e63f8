// Tissue bands behind a curve: their depths and colours.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "app/report/canvas.h"
#include "patient/tissue/tissue.h"

namespace stylet::report {

// In the order of patient::Tissue.
inline constexpr std::array<Colour, patient::kTissueCount> kBandColours{{{0.88, 0.93, 0.97},    // air
                                                                         {0.96, 0.84, 0.76},    // skin
                                                                         {0.99, 0.95, 0.80},    // soft
                                                                         {0.90, 0.88, 0.84},    // bone
                                                                         {0.86, 0.84, 0.95},    // fascia
                                                                         {0.95, 0.83, 0.81},    // liver
                                                                         {0.80, 0.86, 0.97},    // vessel
                                                                         {0.82, 0.93, 0.80},    // duct
                                                                         {0.78, 0.86, 0.86}}};  // cartilage
constexpr Colour bandColour(patient::Tissue tissue) {
    return kBandColours[std::size_t(tissue)];
}

struct TissueBand {
    double from_m = 0.0, to_m = 0.0;  // depth
    patient::Tissue tissue = patient::Tissue::air;
};

// The tissues at the tip over the first `end` samples, an insertion. Assumes that the needle never moves
// back by more than tremor, so each depth belongs to the sample that first reached it.
template <typename Sample>
std::vector<TissueBand> tissueBands(const std::vector<Sample>& curve, std::size_t end) {
    std::vector<TissueBand> bands;
    double reached_m = -1.0;
    for (std::size_t i = 0; i < end;) {
        const patient::Tissue tissue = curve[i].tissue;
        const double from_m = std::max(reached_m, curve[i].depth_m);
        double to_m = from_m;
        for (; i < end && curve[i].tissue == tissue; ++i)
            to_m = std::max(to_m, curve[i].depth_m);
        if (i < end) to_m = std::max(to_m, curve[i].depth_m);
        if (to_m <= from_m) continue;
        reached_m = to_m;
        bands.push_back({from_m, to_m, tissue});
    }
    return bands;
}

}  // namespace stylet::report
