// Inner loop of deform.cpp, private to it: traces a row of the tables' nodes back to the reference.
#pragma once

#include <cstddef>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace stylet::render {

// The current motion on the model's nodes: four floats per node, x-fastest. Displacements are in voxels.
struct FlowNodes {
    const float* wall = nullptr;               // the wall's field
    const float* wall_displacement = nullptr;  // displacement of each node by the wall's flow
    const float* slide = nullptr;              // the slide's field; fourth component: the level, m
    glm::ivec3 dims{0};
    glm::vec3 metres{0.0f};  // size of a voxel
    // Longest path of one midpoint step; a Runge-Kutta step may be eight times as long.
    float step_m = 0.0025f;
    float far_m = 0.01f;  // level beyond which no cell of the tables reaches into the cavity
};

// Computes the displacement of the model's nodes [0, count) of a row by the wall's flow.
using WallRow = void (*)(const FlowNodes&, const glm::vec3& first, int count, float* wall_displacement);
// Computes nodes [0, count) of both tables. They start at `first` and advance by `step` along x, both in
// voxels. `far`: all nodes lie far outside the cavity, and only the outside table is written.
using TableRow = void (*)(const FlowNodes&, const glm::vec3& first, float step, int count, bool far,
                          glm::vec4* inside, glm::vec4* outside);

struct RowKernels {
    WallRow wall;
    TableRow table;
};
RowKernels widestRows();  // AVX2 and FMA where the processor has them
RowKernels portableRows();

}  // namespace stylet::render
