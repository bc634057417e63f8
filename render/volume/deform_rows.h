// The ways back of a row of the tables' nodes: deform.cpp's inner loop, private to it.
#pragma once

#include <cstddef>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace stylet::render {

// A motion of the moment on the model's nodes: four floats each, x-fastest. Displacements are in voxels.
struct FlowNodes {
    const float* wall = nullptr;    // the field
    const float* walled = nullptr;  // its flow: what it moves each node by
    const float* slide = nullptr;   // the field; the fourth: the level, m
    glm::ivec3 dims{0};
    glm::vec3 metres{0.0f};  // a voxel
    float step_m =
        0.0025f;  // the longest way of one midpoint step; an eighth of the longest of Runge and Kutta's
    float far_m = 0.01f;  // a level from which no cell reaches the inside
};

// What the wall's flow moves the model's nodes [0, count) of a row by.
using WallRow = void (*)(const FlowNodes&, const glm::vec3& first, int count, float* walled);
// Nodes [0, count) from `first` by `step` along x, both in voxels, into the two tables: all of them `far`
// outside, where only the outside's way is wanted, or any.
using TableRow = void (*)(const FlowNodes&, const glm::vec3& first, float step, int count, bool far,
                          glm::vec4* inside, glm::vec4* outside);

struct RowKernels {
    WallRow wall;
    TableRow table;
};
RowKernels widestRows();  // AVX2 and FMA where the processor has them
RowKernels portableRows();

}  // namespace stylet::render
