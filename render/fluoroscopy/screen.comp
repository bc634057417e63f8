#version 460
#extension GL_GOOGLE_include_directive : require
// The picture of one pulse: quanta behind the patient, their noise, and the screen's grey values. The noise
// is a function of pixel, pulse and seed. Its random bits: Jarzynski and Olano, "Hash functions for GPU
// rendering", JCGT 9(3), 2020 (pcg4d).
#include "render/fluoroscopy/fluoroscopy_shared.h"

layout(local_size_x = kXrayGroup, local_size_y = kXrayGroup) in;

layout(std140, binding = 0) uniform Uniforms { ScreenUniforms screen; };
layout(std430, binding = 1) readonly buffer Paths { float paths[]; };
layout(std430, binding = 2) readonly buffer Slow { float slow[]; };
layout(std430, binding = 3) writeonly buffer Picture { uint picture[]; };

#include "render/fluoroscopy/collimation.glsl"

uvec4 pcg4d(uvec4 v) {
    v = v * 1664525u + 1013904223u;
    v += v.yzxy * v.wxyz;
    v ^= v >> 16u;
    v += v.yzxy * v.wxyz;
    return v;
}

float uniformFrom(uint bits) { return (float(bits >> 8) + 0.5) / 16777216.0; }  // in (0, 1)

// Poisson distribution by its first three moments (Cornish and Fisher). Every pixel counts at least ten
// quanta, so the error is too small to be visible.
float poisson(float mean, float normal) {
    return max(mean + sqrt(mean) * normal + (normal * normal - 1.0) / 6.0, 0.0);
}

// Mean line integral of the surroundings, interpolated linearly between the lattice's cells.
float slowAt(ivec2 pixel) {
    const int side = int(screen.tone.w);
    const vec2 at = clamp(vec2(pixel) / screen.tone.z, vec2(0.0), vec2(float(side) - 1.0));
    const ivec2 low = min(ivec2(at), ivec2(max(side - 2, 0))), high = min(low + 1, ivec2(side - 1));
    const vec2 f = at - vec2(low);
    return mix(mix(slow[low.y * side + low.x], slow[low.y * side + high.x], f.x),
               mix(slow[high.y * side + low.x], slow[high.y * side + high.x], f.x), f.y);
}

void main() {
    const ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    const int pixels = int(screen.iris.z);
    if (any(greaterThanEqual(pixel, ivec2(pixels)))) return;
    const vec2 at = (vec2(pixel) + 0.5 - 0.5 * float(pixels)) * screen.iris.y;
    const float open = openShare(screen.blades, screen.iris.x, at, screen.iris.y);
    const uvec4 bits = pcg4d(uvec4(pixel, screen.noise.x, screen.noise.y ^ screen.noise.z));
    const float radius = sqrt(-2.0 * log(uniformFrom(bits.x))), angle = 6.2831853 * uniformFrom(bits.y);
    const float mean = screen.quanta.x * exp(-paths[pixel.y * pixels + pixel.x]);
    const float detected = poisson(mean, radius * cos(angle)) + screen.quanta.y * radius * sin(angle);
    const float even = exp(screen.tone.x * (slowAt(pixel) - screen.tone.y));
    const float signal = pow(max(detected, 0.0) / screen.quanta.z * even, screen.quanta.w);
    float grey = signal / (1.0 + signal);
    if (screen.iris.w == 0.0) grey = 1.0 - grey;
    const uint level = uint(clamp(grey * open, 0.0, 1.0) * 255.0 + 0.5);
    picture[pixel.y * pixels + pixel.x] = 0xff000000u | level << 16 | level << 8 | level;
}
