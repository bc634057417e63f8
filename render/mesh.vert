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

void main() {
    eye = eyeIndex(int(part.material.z));
    const vec4 p = part.stage_from_model * vec4(position, 1.0);
    position_stage = p.xyz;
    // Models are scaled along their own axes only: dividing by the squared scale gives the inverse transpose.
    const mat3 m = mat3(part.stage_from_model);
    normal_stage = m * (normal / vec3(dot(m[0], m[0]), dot(m[1], m[1]), dot(m[2], m[2])));
    gl_Position = frame.eyes[eye].clip_from_stage * p;
    routeEye();
}
