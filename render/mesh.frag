#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/bindings.glsl"
#include "render/lighting.glsl"

layout(push_constant) uniform Push { MeshPush part; };
layout(location = 0) in vec3 position_stage;
layout(location = 1) in vec3 normal_stage;
layout(location = 2) flat in int eye;
layout(location = 0) out vec4 colour;

// GGX with Schlick's Fresnel and the visibility term of Hammon 2017 ("PBR Diffuse Lighting for GGX+Smith").
float ggx(vec3 n, vec3 v, vec3 l, float roughness) {
    const vec3 h = normalize(v + l);
    const float a = roughness * roughness, a2 = a * a;
    const float nh = max(dot(n, h), 0.0), nl = max(dot(n, l), 1e-3), nv = max(dot(n, v), 1e-3);
    const float d = nh * nh * (a2 - 1.0) + 1.0;
    return a2 / (3.14159265 * d * d) * 0.5 / mix(2.0 * nl * nv, nl + nv, a);
}

// What the patient leaves of the light on the table: soft, and darkest where he lies.
float patientShadow() {
    if (part.material.w != kShadowed || frame.grid_origin.w == 0.0) return 1.0;
    const vec3 half_size = 0.5 * frame.grid_dims.xyz * frame.grid_spacing.xyz;
    const vec3 middle = frame.grid_origin.xyz + half_size;
    const vec3 p = (frame.patient_from_stage * vec4(position_stage, 1.0)).xyz - middle;
    const vec2 outside = max(abs(p.xz) - half_size.xz * vec2(0.68, 0.97), 0.0) / 0.055;
    return 1.0 - 0.68 * exp(-dot(outside, outside));
}

void main() {
    const vec3 v = normalize(frame.eyes[eye].stage_from_eye[3].xyz - position_stage);
    vec3 n = normalize(normal_stage);
    if (dot(n, v) < 0.0) n = -n;
    const vec3 l = frame.key_stage.xyz;
    const float metallic = part.material.x, roughness = max(part.material.y, 0.08);
    const vec3 base = part.colour.rgb;
    const vec3 f0 = mix(vec3(0.04), base, metallic), albedo = base * (1.0 - metallic);
    const float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 0.0);
    const vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(v, normalize(v + l)), 0.0), 5.0);
    const vec3 key = kKeyColour * frame.key_stage.w * nl;
    const vec3 mirror = ambientLight(reflect(-v, n).y) * mix(1.25, 0.9, roughness);
    const vec3 edge = f0 + (max(vec3(1.0 - roughness), f0) - f0) * pow(1.0 - nv, 5.0);
    vec3 light = albedo * (ambientLight(n.y) + key) + key * fresnel * ggx(n, v, l, roughness) + mirror * edge;
    light += base * part.colour.w;
    colour = vec4(softClip(light * patientShadow()), 1.0);
}
