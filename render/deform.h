// The breath as pictures read it: where each point of the deformed patient came from, as two tables over a
// grid. Agrees with patient::referenceFromDeformed to 0.1 mm.
#pragma once

#include <vector>

#include <glm/vec4.hpp>

#include "patient/patient.h"

namespace stylet::render {

using patient::Vec3;

struct DeformSettings {
    double spacing_m = 0.003;
    int steps = 3;    // midpoint steps of each flow
    int threads = 0;  // 0: half the machine's
};

// x-fastest. Linear between nodes, nothing moves beyond them. Always usable: at least two nodes along each
// axis, all of them still where the patient does not breathe.
struct DeformTables {
    patient::Grid grid;
    // Reference minus deformed in metres, for a point of the inside and of the outside; w of `inside`: level
    // of the deformed point, < 0 inside the cavity.
    std::vector<glm::vec4> inside, outside;
};

DeformTables deformTables(const patient::MotionModel&, const patient::Surrogate& now,
                          const DeformSettings& = {});
// What deform.glsl computes.
Vec3 referenceFromTables(const DeformTables&, const Vec3& deformed_m);

}  // namespace stylet::render
