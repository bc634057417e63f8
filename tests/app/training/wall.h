// A chest wall of slabs with a vessel between the skin and the duct. All border positions are known.
#pragma once

#include "tests/support/duct_path.h"
#include "tests/support/phantom.h"

namespace stylet::test {

// Label ids. They follow the order of tissueLabels().
inline constexpr std::uint8_t kBoneLabel = 3, kLiverLabel = 5, kVesselLabel = 6, kDuctLabel = 7;

// Borders at x = 0, 2, 20, 22, 32 (vessel), 36, 50 (duct) and 56 mm.
inline patient::Package wallWithVessel() {
    using patient::Tissue;
    return makeSlabs({{Tissue::skin, 0.002},
                      {Tissue::soft, 0.018},
                      {Tissue::fascia, 0.002},
                      {Tissue::liver, 0.010},
                      {Tissue::vessel, 0.004},
                      {Tissue::liver, 0.014},
                      {Tissue::duct, 0.006},
                      {Tissue::liver, 0.020}},
                     0.001);
}

inline patient::PlannedPath wallPath() {
    return ductPath();
}

}  // namespace stylet::test
