#version 460
#extension GL_GOOGLE_include_directive : require
// Direct volume rendering of the patient: front to back, in linear light, from the classified volume
// (classified.h). Based on Levoy, "Display of surfaces from volume data", 1988. Leaps over empty bricks:
// Deakin and Knoll, "Efficient ray casting of volumetric images using distance maps for empty space
// skipping", 2020. Samples lie on a fixed lattice per ray. A skip changes the work, never the picture.
#include "render/scene/bindings.glsl"
#include "render/volume/march_shared.h"
#include "render/volume/deform.glsl"
#include "render/scene/lighting.glsl"
#include "render/volume/marks.glsl"

layout(constant_id = 0) const uint kEmptySpace = 1;
layout(constant_id = 1) const uint kEarlyTermination = 1;
layout(constant_id = 2) const uint kDepthBounds = 1;
layout(constant_id = 3) const uint kDeform = 0;
layout(constant_id = 4) const uint kCount = 0;
layout(constant_id = 5) const uint kCuts = 0;
layout(constant_id = 6) const uint kMarks = 0;
layout(constant_id = 7) const uint kFoveate = 0;
layout(constant_id = 8) const uint kTool = 0;

layout(local_size_x = kTile, local_size_y = kTile) in;

vec3 voxel_scale;                  // texture coordinates per voxel

vec4 fetch(vec3 voxel) { return textureLod(classified, (voxel + 0.5) * voxel_scale, 0.0); }
float opacity(vec3 voxel) { return fetch(voxel).a; }

vec3 voxelFromPatient(vec3 p) {
    if (kTool != 0) p -= toolMoved(p);
    const vec3 reference = kDeform != 0 ? referenceFromDeformed(p) : p;
    return (reference - frame.grid_origin.xyz) / frame.grid_spacing.xyz;
}

// Gradient by central differences: opacity per voxel edge of the finest spacing.
vec3 gradient(vec3 v) {
    const float h = look.tint.w;
    const vec3 g = vec3(opacity(v + vec3(h, 0, 0)) - opacity(v - vec3(h, 0, 0)),
                        opacity(v + vec3(0, h, 0)) - opacity(v - vec3(0, h, 0)),
                        opacity(v + vec3(0, 0, h)) - opacity(v - vec3(0, 0, h)));
    const vec3 s = frame.grid_spacing.xyz;
    return 0.5 / h * g * min(s.x, min(s.y, s.z)) / s;
}

Surface surfaceAtVoxel(vec3 voxel, vec3 slope, vec3 albedo) {
    const vec3 normal = -slope / max(length(slope), 1e-6);
    return surfaceAt(frame.grid_origin.xyz + voxel * frame.grid_spacing.xyz, normal, albedo, kMarks != 0);
}
// Detail of a surface as a factor of the albedo.
vec3 surfaceTint(Surface skin, vec3 albedo) {
    return max(skin.albedo, kLeastAlbedo) / max(albedo, kLeastAlbedo);
}

// Uniform light for a sample that contributes little.
vec3 shadeWeak(vec3 albedo) { return albedo * (ambientLight(0.0) + kWeakKey * kKeyColour * frame.key_patient.w); }

vec3 shade(Surface skin, vec3 g, vec3 to_eye) {
    const float steepness = length(g);
    vec3 n = -g / max(steepness, 1e-6);
    // A surface seen from behind shows its other side. At a silhouette, the normal may point slightly away;
    // it is then bent back.
    const float facing = dot(n, to_eye);
    if (facing < 0.0) n = facing < kTurnedAway ? -n : normalize(n - facing * to_eye);
    const vec3 l = frame.key_patient.xyz;
    const float wrap = look.surface.x, nl = dot(n, l);
    const float lit = max((nl + wrap) / (1.0 + wrap), 0.0);
    const vec3 grazing = mix(look.tint.rgb, vec3(1.0), smoothstep(0.0, kGrazingLight, lit));
    const float surface = smoothstep(0.0, kSurface, steepness);
    const vec3 key = kKeyColour * frame.key_patient.w;
    const vec3 h = normalize(l + to_eye);
    const float strength = mix(look.surface.y, kWetStrength, skin.gloss);
    const float power = mix(look.surface.z, kWetPower, skin.gloss);
    const float shine = strength * pow(max(dot(n, h), 0.0), power) * max(nl, 0.0);
    const float rim = look.surface.w * pow(1.0 - max(dot(n, to_eye), 0.0), 3.0);
    const vec3 full = skin.albedo * (ambientLight(dot(n, frame.up_patient.xyz)) + key * lit * grazing) +
                      key * shine + kSkyColour * rim;
    return mix(shadeWeak(skin.albedo), full, surface);
}

// Ray parameter at which the ray leaves the cube of known-empty bricks around `brick`.
float leaveEmpty(vec3 brick, float radius, vec3 origin, vec3 inverse) {
    const vec3 low = (brick - (radius - 1.0)) * kBrick - 0.5, high = (brick + radius) * kBrick - 0.5;
    const vec3 t = max((low - origin) * inverse, (high - origin) * inverse);
    return min(t.x, min(t.y, t.z));
}

// Clips the ray at the cut planes. `face`: index of the cut plane through which it enters, or -1.
void applyCuts(vec3 eye_patient, vec3 direction, inout float t_begin, inout float t_exit, out int face) {
    face = -1;
    for (int i = 0; i < int(frame.layer.z); ++i) {
        const float height = dot(frame.cuts[i].xyz, eye_patient) - frame.cuts[i].w;
        const float slope = dot(frame.cuts[i].xyz, direction);
        const float t = -height / (abs(slope) < 1e-9 ? 1e-9 : slope);
        if (slope >= 0.0) t_exit = min(t_exit, height > 0.0 && slope < 1e-9 ? -1.0 : t);
        else if (t > t_begin) t_begin = t, face = i;
    }
}

struct RayResult {
    vec4 colour;  // premultiplied
    float depth;  // m; 0: no opaque surface
};

// `at`: position of the ray as shares of the target.
RayResult march(int eye, ivec2 pixel, vec2 at, vec2 footprint) {
    const EyeUniforms e = frame.eyes[eye];
    const vec3 direction = mat3(e.patient_from_eye) * rayThrough(e.tangents, at);
    const vec3 to_eye = -normalize(direction);
    const vec3 eye_patient = e.patient_from_eye[3].xyz;
    const vec3 spacing = frame.grid_spacing.xyz;
    // In voxels of the deformed patient's grid.
    const vec3 origin = (eye_patient - frame.grid_origin.xyz) / spacing, ray = direction / spacing;
    const vec3 inverse = 1.0 / mix(ray, vec3(1e-9), lessThan(abs(ray), vec3(1e-9)));
    voxel_scale = 1.0 / frame.grid_dims.xyz;

    const vec3 ta = (vec3(-0.5) - origin) * inverse, tb = (frame.grid_dims.xyz - 0.5 - origin) * inverse;
    const vec3 t_low = min(ta, tb), t_high = max(ta, tb);
    float t_begin = max(max(t_low.x, max(t_low.y, t_low.z)), frame.target.z);
    float t_exit = min(t_high.x, min(t_high.y, t_high.z));
    int face = -1;
    if (kCuts != 0) applyCuts(eye_patient, direction, t_begin, t_exit, face);
    const float t_mesh = meshDepth(pixel, eye);
    if (t_exit <= t_begin) return RayResult(vec4(0.0), 0.0);

    const float metres = length(direction);  // per unit of t
    const float finest = min(spacing.x, min(spacing.y, spacing.z));
    // A step is at least as long as a pixel is wide.
    const float step_m = max(frame.grid_spacing.w * finest, frame.fovea.z * t_begin * max(footprint.x, footprint.y));
    const float step_t = step_m / metres;
    const float quarter = step_t / float(kFine), voxel_t = finest / metres;
    // The start varies from pixel to pixel, which turns the remaining bands into grain too fine to see.
    const float offset = fract(kDither.x * fract(dot(floor(at * frame.layer.xy), kDither.yz)));
    const float t_first = t_begin + offset * step_t;
    const float t_end = kDepthBounds != 0 ? min(t_exit, t_mesh + 0.5 * step_t) : t_exit;
    const int last = kFine * int(ceil((t_end - t_first) / step_t));
    const float sigma_full = frame.grid_dims.w * metres;
    const ivec3 bricks = ivec3(frame.brick_dims.xyz);

    // Weak samples wait for the surface behind them and take its tint, or bare skin would shine through blood.
    vec3 light = vec3(0.0), weak = vec3(0.0), tint = vec3(1.0);
    vec3 weak_voxel = vec3(0.0), weak_albedo = vec3(0.0);  // of the weightiest weak sample
    float weightiest = 0.0;
    bool met = false;
    float transmittance = 1.0, depth = 0.0;
    uint samples = 0, leaps = 0;
    int fine_until = -1;
    int q = 0;  // position on the lattice, in quarter steps
    // Two loops, because a SIMD machine that masks its branches executes all of a loop's body. The inner loop
    // needs one fetch per sample. It ends at a sample that contributes enough to need the six fetches of a
    // gradient.
    while (q <= last) {
        vec3 voxel = vec3(0.0), albedo = vec3(0.0);
        float strong = 0.0, t = 0.0;
        while (strong == 0.0 && q <= last) {
            t = t_first + float(q) * quarter;
            const vec3 v = origin + ray * t;
            const bool fine = q <= fine_until;
            if (kEmptySpace != 0 && !fine) {
                const ivec3 b = clamp(ivec3((v + 0.5) / kBrick), ivec3(0), bricks - 1);
                const uint radius = brick_distance[(b.z * bricks.y + b.y) * bricks.x + b.x];
                if (radius > 0) {
                    const float t_out = leaveEmpty(vec3(b), float(radius), origin, inverse);
                    q = max(q + kFine, kFine * int(ceil((t_out - t_first) / step_t)));
                    ++leaps;
                    continue;
                }
            }
            voxel = kDeform != 0 || kTool != 0 ? voxelFromPatient(frame.grid_origin.xyz + v * spacing) : v;
            const vec4 texel = fetch(voxel);
            ++samples;
            const float sigma = texel.a * texel.a * sigma_full;
            const bool dense = sigma * step_t > kDense;
            if (!fine && dense) {
                fine_until = q;
                q = max(q - kFine + 1, -int(offset * float(kFine)));
                continue;
            }
            const float width = fine ? quarter : step_t;
            const float inside = clamp((t_mesh - t) / width + 0.5, 0.0, 1.0);
            const float alpha = 1.0 - exp(-sigma * width * inside);
            const float weight = transmittance * alpha;
            const vec3 root = texel.rgb / max(texel.a, 1e-4);
            albedo = root * root;
            if (transmittance * min(sigma * voxel_t, 1.0) > kWeak) {
                strong = weight;
            } else {
                weak += weight * shadeWeak(albedo);
                if (weight > weightiest) weightiest = weight, weak_voxel = voxel, weak_albedo = albedo;
            }
            transmittance -= weight;
            if (depth == 0.0 && transmittance < 0.5) depth = t;
            if (q == fine_until && dense) fine_until += kFine;
            q += q < fine_until ? 1 : kFine;
            if (kEarlyTermination != 0 && transmittance < kOpaque) q = kDone;
        }
        if (strong > 0.0) {
            // A cut surface is lit as a plane.
            const bool cut = kCuts != 0 && face >= 0 && t - t_begin < kCutSteps * step_t;
            vec3 slope = cut ? -frame.cuts[max(face, 0)].xyz : gradient(voxel);
            if (kTool != 0 && !cut) slope = turnedByTool(frame.grid_origin.xyz + (origin + ray * t) * spacing, slope);
            Surface skin = Surface(albedo, 0.0);
            if (!cut) skin = surfaceAtVoxel(voxel, slope, albedo);
            tint = surfaceTint(skin, albedo), met = true;
            light += strong * shade(skin, slope, to_eye) + weak * tint;
            weak = vec3(0.0);
        }
    }
    // At the skin's outline no sample is strong. A loop, because lavapipe runs the body of an if for every pixel.
    const bool outline = !met && look.detail.x > 0.0 && weightiest > 0.0;
    for (int once = 0; once < int(outline); ++once)
        tint = surfaceTint(surfaceAtVoxel(weak_voxel, gradient(weak_voxel), weak_albedo), weak_albedo);
    light += weak * tint;
    if (transmittance < kOpaque) transmittance = 0.0;
    if (kCount != 0) {
        atomicAdd(counters.rays, 1);
        if (atomicAdd(counters.samples, samples) > 0xffffffffu - samples) atomicAdd(counters.samples_high, 1);
        atomicAdd(counters.skipped_bricks, leaps);
        if (q == kDone) atomicAdd(counters.terminated_rays, 1);
        if (kDepthBounds != 0 && t_mesh + 0.5 * step_t < t_exit) atomicAdd(counters.depth_bounded_rays, 1);
    }
    const float alpha = 1.0 - transmittance;
    return RayResult(vec4(softClip(light / max(alpha, 1e-4)) * alpha, alpha), depth);
}

// Number of pixels along either axis that share a ray in this tile.
int raySize(int eye) {
    if (kFoveate == 0) return 1;
    const vec2 at = (vec2(gl_WorkGroupID.xy) + 0.5) * float(kTile) / frame.layer.xy;
    const float away = length(rayThrough(frame.eyes[eye].tangents, at).xy);
    return away > frame.fovea.y ? 4 : away > frame.fovea.x ? 2 : 1;
}

void main() {
    const int eye = int(gl_WorkGroupID.z);
    const int size = raySize(eye), rays = kTile / size;
    const int index = int(gl_LocalInvocationIndex);
    if (index >= rays * rays) return;  // where pixels share rays, whole subgroups return here
    const ivec2 low = ivec2(gl_WorkGroupID.xy) * kTile + ivec2(index % rays, index / rays) * size;
    const ivec2 extent = ivec2(frame.layer.xy);
    if (any(greaterThanEqual(low, extent))) return;
    const vec2 at = min((vec2(low) + 0.5 * float(size)) / frame.layer.xy, 1.0);
    const ivec2 pixel = min(ivec2(at * frame.target.xy), ivec2(frame.target.xy) - 1);
    const vec2 range = abs(frame.eyes[eye].tangents.yw - frame.eyes[eye].tangents.xz);
    const RayResult seen = march(eye, pixel, at, float(size) * range / frame.layer.xy);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) {
            const ivec2 to = low + ivec2(x, y);
            if (any(greaterThanEqual(to, extent))) continue;
            imageStore(layer_colour, ivec3(to, eye), seen.colour);
            imageStore(layer_depth, ivec3(to, eye), vec4(seen.depth));
        }
}
