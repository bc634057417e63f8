#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/scene/bindings.glsl"
#include "render/scene/lighting.glsl"

layout(location = 0) flat in int eye;
layout(location = 0) out vec4 colour;

const vec3 kWallLow = vec3(0.020, 0.052, 0.058), kWallHigh = vec3(0.055, 0.115, 0.120);
const vec3 kGround = vec3(0.058, 0.082, 0.086);

float floorShadow(vec2 p) {
    if (frame.shadow_stage.z <= 0.0) return 1.0;
    const vec2 d = p - frame.shadow_stage.xy, axis = frame.shadow_axis_stage.xy;
    const vec2 q = vec2(dot(d, vec2(-axis.y, axis.x)), dot(d, axis)) / frame.shadow_stage.zw;
    return 1.0 - 0.72 * exp(-1.1 * dot(q, q));
}

// A room without walls: dark teal that brightens towards the lamp, and a polished floor at y = 0.
void main() {
    const EyeUniforms e = frame.eyes[eye];
    const vec3 d = normalize(mat3(e.stage_from_eye) * rayThrough(e.tangents, gl_FragCoord.xy / frame.target.xy));
    const vec3 eye_stage = e.stage_from_eye[3].xyz;
    const float lamp = pow(max(dot(d, frame.key_stage.xyz), 0.0), 6.0);
    const vec3 wall = mix(kWallLow, kWallHigh, smoothstep(-0.2, 0.9, d.y)) + vec3(0.10, 0.14, 0.14) * lamp;
    vec3 light = wall;
    if (d.y < -1e-3 && eye_stage.y > 0.0) {
        const float t = -eye_stage.y / d.y;
        const vec2 p = eye_stage.xz + t * d.xz;
        const float pool = exp(-0.16 * dot(p - frame.shadow_stage.xy, p - frame.shadow_stage.xy));
        const float shine = pow(1.0 + d.y, 4.0);
        const vec3 ground = kGround * (0.55 + 1.1 * pool) * floorShadow(p) + 0.5 * kWallHigh * shine;
        light = mix(ground, wall, smoothstep(3.0, 14.0, t));
    }
    light *= room.shell.rgb;
    // Half a step of ordered noise hides the bands of an 8-bit gradient.
    const float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    colour = vec4(light + (noise - 0.5) * 0.004 * sqrt(light), 1.0);
}
