#version 460
#extension GL_GOOGLE_include_directive : require

// Fills places[]: the displacement of the tissue by breath and tool (reference minus deformed), on a coarse
// grid of the scan.
layout(local_size_x = 64) in;
#include "render/ultrasound/bindings.glsl"
#include "render/ultrasound/places.glsl"

void main() {
    const int column = int(gl_GlobalInvocationID.x), row = int(gl_GlobalInvocationID.y);
    const int plane = int(gl_GlobalInvocationID.z);
    if (column >= kPlaceColumns) return;
    // Beyond the last line, the last one is repeated.
    const vec3 p = sampleAt(min(row * kCoarseLines, kLines - 1), float(column * kCoarse), plane);
    places[(plane * kPlaceRows + row) * kPlaceColumns + column] = vec4(referencePosition(p) - p, 0.0);
}
