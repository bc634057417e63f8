// Observes the fascia in a CT as the cheapest surface r(phi, z) through the edges between the body wall's
// muscle and the tissue inside it.
// Based on Li, Wu, Chen and Sonka, "Optimal surface segmentation in volumetric images: a graph-theoretic
// approach", IEEE TPAMI 28, 2006 (a surface as a height over an unfolded volume), and Ishikawa, "Exact
// optimization for Markov random fields with convex priors", IEEE TPAMI 25, 2003 (the graph).
#pragma once

#include <span>
#include <vector>

#include "app/modeller/wall/body_wall.h"

namespace stylet::modeller {

// The fascia's inner face per cell of a wall surface.
struct ObservedFascia {
    std::vector<double> radius_m;
    std::vector<double> weight;  // 0 to 1: how clearly the CT shows it there
};

// How much a sample of a profile looks like the inner face of the body wall, 0 to 1.
struct WallEvidence {
    float edge = 0.0f;  // from muscle to thick fat or lung
    float line = 0.0f;  // inside the diaphragm: a thin dark line between muscle and an organ, or ascites
};
// The profile runs outward in steps of kProfileStep_m.
inline constexpr double kProfileStep_m = 0.0005;
WallEvidence wallEvidence(std::span<const float> profile_hu, int sample);

// Searches within 12 mm of `near`. Prefers radii within `bounds`, and close to the inside of the ribs. Where
// the diaphragm lies on the ribs, it hides the fascia. The CT then shows the diaphragm's inner face, and the
// fascia is one diaphragm thickness outside it. The thickness is measured under the ribs of this scan.
ObservedFascia observeFascia(const FasciaInput&, const WallSurface& near, const RadiusBounds& bounds);

}  // namespace stylet::modeller
