// The breathing motion for pictures: two tables over a grid that give the reference point of each deformed
// point. Agrees with patient::referenceFromDeformed to 0.1 mm.
#pragma once

#include <cstddef>
#include <vector>

#include <glm/vec4.hpp>

#include "patient/displacement/tool_displacement.h"
#include "patient/patient.h"
#include "render/volume/workers.h"

namespace stylet::render {

struct DeformSettings {
    double spacing_m = 0.003;
    // Longest path of one midpoint step; a Runge-Kutta step may be eight times as long.
    double step_m = 0.0025;
    bool portable = false;  // without AVX2 and FMA
};

// x-fastest. Linear between nodes; outside the grid the border's value. Always usable: at least two nodes
// along each axis, all without motion if the patient does not breathe.
struct DeformTables {
    Grid grid;
    // Reference minus deformed point in metres: one table for points inside the cavity, one for points
    // outside. w of `inside`: level of the deformed point, < 0 inside the cavity.
    std::vector<glm::vec4> inside, outside;
};

// Recomputes the tables for each breath. Use from one thread at a time.
class DeformTableBuilder {
  public:
    // `seen`: the patient that is drawn. Only nodes that its body can reach are computed. Null: all of the
    // motion's box. The model must outlive this object.
    DeformTableBuilder(const patient::MotionModel&, const DeformSettings&, const patient::Patient* seen);

    // Allocates nothing.
    void compute(const patient::Surrogate& now, Workers&);

    const DeformTables& tables() const { return tables_; }
    double reach_m() const { return reach_m_; }  // upper bound of any point's displacement
    std::size_t computedNodes() const { return made_; }

  private:
    struct Node {
        float x = 0.0f, y = 0.0f, z = 0.0f, level = 0.0f;
    };
    // Nodes [begin, end) of a row. `far`: far outside the cavity, where only the wall's flow moves tissue.
    struct NodeRun {
        int y = 0, begin = 0, end = 0;
        bool far = false;
    };
    std::vector<NodeRun> findBodyRuns(const patient::Patient&) const;
    void findRuns(const patient::Patient* seen);
    void setFields(const patient::Surrogate& now, Workers&);

    const patient::MotionModel* model_;
    DeformSettings settings_;
    DeformTables tables_;
    std::vector<NodeRun> runs_;             // ordered by z
    std::vector<std::size_t> first_of_z_;   // index of each slice's first run, and the end
    std::vector<Node> wall_, slide_;        // fields of the two flows, in the model's voxels, with the level
    std::vector<Node> wall_displacements_;  // displacement of each node by the complete wall flow
    double far_m_ = 0.0, reach_m_ = 0.0;
    std::size_t made_ = 0;
};

// Computes the tables once, over all of the motion's box.
DeformTables deformTables(const patient::MotionModel&, const patient::Surrogate& now,
                          const DeformSettings& = {}, int threads = 2);
// The same look-up as in deform.glsl.
Vec3 referenceFromTables(const DeformTables&, const Vec3& deformed_m);
// Undoes the tool's displacement first.
Vec3 referenceFromTables(const DeformTables&, const patient::DisplacementTable&, const Vec3& displaced_m);

}  // namespace stylet::render
