#version 460
#extension GL_GOOGLE_include_directive : require
// Lights the meshes of the room, in the room frame. A software rasteriser computes both sides of every
// branch, so features that only some meshes need are specialisation constants.
#include "render/scene/bindings.glsl"
#include "render/scene/lighting.glsl"

layout(constant_id = 0) const int kKind = 0;       // kPlain, kTable, kFloor, kScreen, kCloth, kGhost
layout(constant_id = 1) const int kLamp = 0;       // kUnlit, kFromAfar, kBeam

layout(push_constant) uniform Push { MeshPush part; };
layout(location = 0) in vec3 position;   // room
layout(location = 1) in vec3 raw_normal; // room
layout(location = 2) in vec4 around;     // ambient irradiance over pi; a: share of it that reaches the point
layout(location = 3) in vec2 uv;
layout(location = 4) flat in vec3 base;
layout(location = 5) flat in vec3 surface;  // metallic, roughness, emission
layout(location = 6) in vec3 to_eye;    // room
layout(location = 0) out vec4 colour;

const float kGlow = 2.5;           // radiance at emission 1
const float kLampBreadth = 0.10;   // added to the roughness in the lamp's highlight: the lamp is no point

// GGX with the visibility term of Hammon 2017 ("PBR Diffuse Lighting for GGX+Smith").
float ggx(float nh, float nl, float nv, float roughness) {
    const float a = roughness * roughness, a2 = a * a;
    const float d = nh * nh * (a2 - 1.0) + 1.0;
    return a2 / (3.14159265 * d * d) * 0.5 / mix(2.0 * nl * nv, nl + nv, a);
}

// Radiance that arrives at point `p` from direction `r`. The map was gathered at kGatherPoint, so the ray is
// first intersected with the walls.
vec3 roomMirror(vec3 p, vec3 r, float roughness) {
    const vec3 safe = mix(r, vec3(1e-4), lessThan(abs(r), vec3(1e-4)));
    const vec3 t = (sign(safe) * kRoomHalf - (p - vec3(0.0, kRoomHalf.y, 0.0))) / safe;
    vec3 d = p + max(min(t.x, min(t.y, t.z)), 0.05) * r - kGatherPoint;
    d /= abs(d.x) + abs(d.y) + abs(d.z);
    const vec2 at = d.y >= 0.0 ? d.xz : (1.0 - abs(d.zx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(d.xz, vec2(0.0)));
    const vec2 place = (0.5 * at + 0.5) * ((float(kMapSize) - 1.0) / float(kMapSize)) + 0.5 / float(kMapSize);
    const vec3 root = textureLod(environment, vec3(place, round(roughness * (float(kMapLevels) - 1.0))), 0.0).rgb;
    return kMapRange * root * root;
}

// Strength of the lamp's light without shadows, relative to that at the field: a pool of half a metre, and no
// light beyond a metre.
float beamStrength() {
    const vec3 from = position - room.lamp.xyz;
    const float along = dot(from, room.beam.xyz), d2 = dot(from, from);
    const float away = 11.0 * (d2 / max(along * along, 1e-4) - 1.0), away2 = away * away;
    const float pool = 0.84 / (1.0 + away2 * away2) + 0.16 / (1.0 + away2);
    return along > 0.0 ? max(pool - kBeamEdge, 0.0) * min(room.beam.w * room.beam.w / d2, 2.5) : 0.0;
}

// Share of the light on the table that the patient does not block: a soft shadow, darkest under the patient.
float patientShadow() {
    if (frame.grid_origin.w == 0.0) return 1.0;
    const vec3 half_size = 0.5 * frame.grid_dims.xyz * frame.grid_spacing.xyz;
    const vec3 middle = frame.grid_origin.xyz + half_size;
    const vec3 p = (room.patient_from_room * vec4(position, 1.0)).xyz - middle;
    const vec2 outside = max(abs(p.xz) - half_size.xz * vec2(0.68, 0.97), 0.0) / 0.055;
    return 1.0 - 0.68 * exp(-dot(outside, outside));
}

// Share of the light on the floor that the objects standing there do not block.
float contactShadow() {
    float open = 1.0;
    for (int i = 0; i < kMaxContacts; ++i) {  // constant length: a gather costs more than the empty entries
        const vec4 foot = room.contacts[i];
        const vec2 beside = max(abs(position.xz - foot.xy) - 0.85 * foot.zw, 0.0) + min(foot.z, 0.0) * -1e3;
        const float near = 1.0 / (1.0 + 45.0 * dot(beside, beside));
        open *= 1.0 - 0.66 * near * near;
    }
    return open;
}

// A picture, box-filtered over the pixel; an idle screen glows faintly.
vec3 screenLight(int screen) {
    const vec4 shown = room.screens[screen];
    const vec2 dx = dFdx(uv) * 0.25, dy = dFdy(uv) * 0.25;
    const float half_texel = 0.5 / float(kScreenPixels);
    const vec2 low = vec2(half_texel), high = shown.xy - half_texel;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        const vec2 at = (uv + ((i & 1) * 2 - 1) * dx + ((i >> 1) * 2 - 1) * dy) * shown.xy;
        sum += textureLod(screens, vec3(clamp(at, low, high), float(screen)), 0.0).rgb;
    }
    const vec2 q = uv - 0.5;
    return shown.z == 0.0 ? vec3(0.010, 0.016, 0.020) * (1.0 - 0.6 * dot(q, q)) : sum * 0.25;
}

void main() {
    // Translucent without sorting: every other pixel is left out.
    if (kKind == kGhost && ((int(gl_FragCoord.x) + int(gl_FragCoord.y)) & 1) == 0) discard;
    const vec3 v = normalize(to_eye);
    vec3 n = normalize(raw_normal);
    if (kKind == kCloth) n = dot(n, v) < 0.0 ? -n : n;  // seen from both sides
    // At a silhouette, an interpolated normal may point away from the eye. Bend it back.
    const float facing = dot(n, v);
    n = facing < 0.0 ? normalize(n - 1.02 * facing * v) : n;
    const float metallic = surface.x, roughness = max(surface.y, 0.08), nv = max(facing, 0.001);
    const vec3 tinted = base * part.colour.rgb;
    const vec3 f0 = mix(vec3(0.04), tinted, metallic), albedo = tinted * (1.0 - metallic);
    float open = 1.0;
    if (kKind == kTable) open = patientShadow();
    if (kKind == kFloor) open = contactShadow();

    // Split sum, with the fit of Karis, "Physically Based Shading on Mobile", 2014.
    const vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    const float share = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    const vec3 mirrored = f0 * (r.z - 1.04 * share) + (r.w + 1.04 * share);
    vec3 light = open * (albedo * around.rgb +
                         around.a * mirrored * roomMirror(position, reflect(-v, n), roughness)) +
                 tinted * (surface.z * kGlow + part.colour.w);
    if (kKind == kScreen) light += screenLight(int(part.material.x) - 1);

    if (kLamp != kUnlit) {
        const vec3 l = kLamp == kBeam ? normalize(room.lamp.xyz - position) : room.lamp.xyz;
        const float nl = max(dot(n, l), 0.0);
        float strength = nl * frame.key_stage.w * mix(1.0, open * around.a, 0.5);
        if (kLamp == kBeam)
            strength *= beamStrength() * lampShadowAt(room.shadow_from_room * vec4(position + 0.003 * n, 1.0));
        const vec3 h = normalize(v + l);
        const float away = 1.0 - max(dot(v, h), 0.0), away2 = away * away;
        const vec3 fresnel = f0 + (1.0 - f0) * (away2 * away2 * away);
        const float lobe = ggx(max(dot(n, h), 0.0), max(nl, 1e-3), nv, roughness + kLampBreadth);
        light += kKeyColour * strength * (albedo + fresnel * lobe);
    }
    light *= mix(vec3(1.0), room.shell.rgb, part.material.y);
    const bool clear = kKind == kScreen && room.screens[int(part.material.x) - 1].w > 0.0;
    colour = vec4(softClip(light), clear ? 0.0 : 1.0);
}
