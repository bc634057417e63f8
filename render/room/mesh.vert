#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/scene/stereo.glsl"
#include "render/scene/bindings.glsl"

layout(push_constant) uniform Push { MeshPush part; };
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;
layout(location = 3) in vec4 root_colour;  // square roots of linear light; a: share of the ambient light
layout(location = 4) in vec4 material;     // metallic, roughness, emission
layout(location = 0) out vec3 position_room;
layout(location = 1) out vec3 normal_room;
layout(location = 2) out vec4 around;
layout(location = 3) out vec2 texture_uv;
layout(location = 4) flat out vec3 base;
layout(location = 5) flat out vec3 surface;
layout(location = 6) out vec3 to_eye;

const float kMinRadius_px = 0.9;  // a thinner shaft would break into dashes

// Widens an object that is thin about its z axis to at least kMinRadius_px. Returns the moved point.
vec3 widened(vec3 p, int eye) {
    const vec3 on_axis = (part.stage_from_model * vec4(0.0, 0.0, position.z, 1.0)).xyz;
    const vec3 outward = p - on_axis;
    const EyeUniforms e = frame.eyes[eye];
    const float depth = (e.clip_from_stage * vec4(on_axis, 1.0)).w;
    const float least = kMinRadius_px * depth * (e.tangents.y - e.tangents.x) / frame.target.x;
    const float radius = length(outward);
    return radius > 1e-6 && radius < least ? on_axis + outward * (least / radius) : p;
}

// Ambient irradiance over pi. It varies so slowly that once per vertex is enough.
vec3 roomIrradiance(vec3 n) {
    return max(0.282095 * room.irradiance[0].rgb +
               0.488603 * (n.y * room.irradiance[1].rgb + n.z * room.irradiance[2].rgb + n.x * room.irradiance[3].rgb) +
               1.092548 * (n.x * n.y * room.irradiance[4].rgb + n.y * n.z * room.irradiance[5].rgb +
                           n.x * n.z * room.irradiance[7].rgb) +
               0.315392 * (3.0 * n.z * n.z - 1.0) * room.irradiance[6].rgb +
               0.546274 * (n.x * n.x - n.y * n.y) * room.irradiance[8].rgb, 0.0);
}

void main() {
    const int eye = eyeIndex(int(part.material.z));
    vec4 p = part.stage_from_model * vec4(position, 1.0);
    if (part.material.w == kThin) p.xyz = widened(p.xyz, eye);
    position_room = (room.room_from_stage * p).xyz;
    to_eye = room.eyes[eye].xyz - position_room;
    // Models are scaled only along their own axes, so dividing by the squared scale gives the inverse
    // transpose.
    const mat3 m = mat3(part.stage_from_model);
    normal_room = mat3(room.room_from_stage) *
                  normalize(m * (normal / vec3(dot(m[0], m[0]), dot(m[1], m[1]), dot(m[2], m[2]))));
    around = vec4(roomIrradiance(normal_room) * root_colour.a, root_colour.a);
    texture_uv = uv;
    base = root_colour.rgb * root_colour.rgb;
    surface = material.xyz;
    gl_Position = frame.eyes[eye].clip_from_stage * p;
    routeEye();
}
