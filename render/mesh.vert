#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/stereo.glsl"
#include "render/bindings.glsl"

layout(push_constant) uniform Push { MeshPush part; };
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 0) out vec3 position_stage;
layout(location = 1) out vec3 normal_stage;
layout(location = 2) flat out int eye;

const float kLeastRadius_px = 0.9;  // thinner, and a shaft breaks into dashes

// A point of a thing that is thin about its z axis, moved outward until it covers pixels.
vec3 widened(vec3 p) {
    const vec3 on_axis = (part.stage_from_model * vec4(0.0, 0.0, position.z, 1.0)).xyz;
    const vec3 outward = p - on_axis;
    const EyeUniforms e = frame.eyes[eye];
    const float depth = (e.clip_from_stage * vec4(on_axis, 1.0)).w;
    const float least = kLeastRadius_px * depth * (e.tangents.y - e.tangents.x) / frame.target.x;
    const float radius = length(outward);
    return radius > 1e-6 && radius < least ? on_axis + outward * (least / radius) : p;
}

void main() {
    eye = eyeIndex(int(part.material.z));
    vec4 p = part.stage_from_model * vec4(position, 1.0);
    if (part.material.w == kThin) p.xyz = widened(p.xyz);
    position_stage = p.xyz;
    // Models are scaled along their own axes only: dividing by the squared scale gives the inverse transpose.
    const mat3 m = mat3(part.stage_from_model);
    normal_stage = m * (normal / vec3(dot(m[0], m[0]), dot(m[1], m[1]), dot(m[2], m[2])));
    gl_Position = frame.eyes[eye].clip_from_stage * p;
    routeEye();
}
