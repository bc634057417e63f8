// Descriptor set 0 of every pipeline, and functions that read it.
#include "render/scene/frame_shared.h"
#include "render/room/room_shared.h"

layout(std140, set = 0, binding = 0) uniform Frame { FrameUniforms frame; };
layout(std140, set = 0, binding = 1) uniform LookBlock { LookUniforms look; };
layout(set = 0, binding = 2) uniform sampler3D classified;       // opacity-weighted colour: classified.h
layout(set = 0, binding = 3) uniform sampler2DArray mesh_depth;  // reversed depth, one layer per eye
layout(std430, set = 0, binding = 4) readonly buffer Bricks { uint brick_distance[]; };
layout(set = 0, binding = 5) uniform sampler3D deform_inside;    // see deform.h
layout(std430, set = 0, binding = 6) buffer Count { Counters counters; };
layout(set = 0, binding = 7) uniform sampler3D deform_outside;
// Linear, premultiplied; one layer per eye.
layout(set = 0, binding = 8, rgba16f) uniform image2DArray layer_colour;
// Depth of the first surface along the eye's -z, m; 0: none.
layout(set = 0, binding = 9, r32f) uniform image2DArray layer_depth;
layout(set = 0, binding = 10) uniform sampler3D tool_moved;        // see deform.glsl
layout(std140, set = 0, binding = 11) uniform RoomBlock { RoomUniforms room; };
// Octahedral, one layer per roughness: environment.h.
layout(set = 0, binding = 12) uniform sampler2DArray environment;
// Reversed depth, as seen from the lamp.
layout(set = 0, binding = 13) uniform sampler2DArrayShadow lamp_shadow;
layout(set = 0, binding = 14) uniform sampler2DArray screens;           // ultrasound, X-ray, monitor

// Depth of the opaque meshes at a pixel of the target, m along the eye's -z.
float meshDepth(ivec2 pixel, int eye) {
    const float d = texelFetch(mesh_depth, ivec3(pixel, eye), 0).r;
    const float near = frame.target.z, far = frame.target.w;
    return near * far / (near + d * (far - near));
}

// Direction of the ray through a point of the target (shares of its size), in the eye's frame.
vec3 rayThrough(vec4 tangents, vec2 at) {
    return vec3(mix(tangents.x, tangents.y, at.x), mix(tangents.z, tangents.w, at.y), -1.0);
}
