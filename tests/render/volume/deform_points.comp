#version 460
#extension GL_GOOGLE_include_directive : require

// One invocation per point. Replaces each deformed point by its reference point.
layout(local_size_x = 64) in;

struct Placement {
    vec4 deform_scale, deform_offset, tool_scale, tool_offset;
};
layout(push_constant) uniform Push {
    Placement frame;
    uint count;
};
layout(set = 0, binding = 0) uniform sampler3D deform_inside;
layout(set = 0, binding = 1) uniform sampler3D deform_outside;
layout(set = 0, binding = 3) uniform sampler3D tool_moved;
layout(std430, set = 0, binding = 2) buffer Points {
    vec4 points[];
};

#include "render/volume/deform.glsl"

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < count) points[i].xyz = referenceFromDeformed(points[i].xyz - toolMoved(points[i].xyz));
}
