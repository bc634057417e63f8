// The breath as pictures read it: where each point of the deformed patient came from, as two tables over a
// grid. Agrees with patient::referenceFromDeformed to 0.1 mm.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/vec4.hpp>

#include "patient/patient.h"
#include "patient/tool_displacement.h"
#include "render/volume/workers.h"

namespace stylet::render {

using patient::Vec3;

struct DeformSettings {
    double spacing_m = 0.003;
    double step_m = 0.0025;  // the longest way of one midpoint step; eight of them for Runge and Kutta's
    bool portable = false;   // without wider instructions
};

// x-fastest. Linear between nodes, the border's beyond them. Always usable: at least two nodes along each
// axis, all of them still where the patient does not breathe.
struct DeformTables {
    patient::Grid grid;
    // Reference minus deformed in metres, for a point of the inside and of the outside; w of `inside`: level
    // of the deformed point, < 0 inside the cavity.
    std::vector<glm::vec4> inside, outside;
};

// Makes the tables anew for each breath. One thread at a time.
class DeformMaker {
  public:
    // `seen`: only the patient's box, and in it only what can be of his body; null: all of the motion's box.
    // The model must outlive it.
    DeformMaker(const patient::MotionModel&, const DeformSettings&, const patient::Patient* seen);

    // Allocates nothing.
    void make(const patient::Surrogate& now, Workers&);

    const DeformTables& tables() const { return tables_; }
    double reach_m() const { return reach_m_; }  // no point is farther from where it came from
    std::size_t nodesMade() const { return made_; }

  private:
    struct Node {
        float x = 0.0f, y = 0.0f, z = 0.0f, level = 0.0f;
    };
    // Nodes [begin, end) of a row; what is far outside the cavity only the wall moves.
    struct Stretch {
        int y = 0, begin = 0, end = 0;
        bool far = false;
    };
    std::vector<Stretch> bodyOf(const patient::Patient&) const;
    void findStretches(const patient::Patient* seen);
    void setFields(const patient::Surrogate& now, Workers&);

    const patient::MotionModel* model_;
    DeformSettings settings_;
    DeformTables tables_;
    std::vector<Stretch> stretches_;       // z after z
    std::vector<std::size_t> first_of_z_;  // one more than there are slices
    std::vector<Node> wall_, slide_;       // what a flow moves by, in the model's voxels; the level beside it
    std::vector<Node> walled_;             // where all of the wall's flow takes a node, less the node
    double far_m_ = 0.0, reach_m_ = 0.0;
    std::size_t made_ = 0;
};

// Once, over all of the motion's box.
DeformTables deformTables(const patient::MotionModel&, const patient::Surrogate& now,
                          const DeformSettings& = {}, int threads = 2);
// What deform.glsl computes.
Vec3 referenceFromTables(const DeformTables&, const Vec3& deformed_m);
// The tool undone first.
Vec3 referenceFromTables(const DeformTables&, const patient::DisplacementTable&, const Vec3& displaced_m);

}  // namespace stylet::render
