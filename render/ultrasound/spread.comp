#version 460
#extension GL_GOOGLE_include_directive : require

// Applies the beam's width and electronic noise, then computes the envelope and its logarithm.
layout(local_size_x = 64) in;
#include "render/ultrasound/bindings.glsl"

const int kMaxBeamTaps = 24;

// Pcg hash, Jarzynski and Olano 2020, Journal of Computer Graphics Techniques 9(3).
uint scrambled(uint v) {
    v = v * 747796405u + 2891336453u;
    v = ((v >> ((v >> 28u) + 4u)) ^ v) * 277803737u;
    return (v >> 22u) ^ v;
}

// Two pseudo-random numbers, nearly normally distributed with unit variance.
vec2 thermal(uint seed) {
    const uint a = scrambled(seed), b = scrambled(a);
    const vec4 u = vec4(a & 0xffffu, a >> 16u, b & 0xffffu, b >> 16u) * (1.0 / 65535.0);
    return (u.xy + u.zw - 1.0) * 2.449489743;
}

void main() {
    const int j = int(gl_GlobalInvocationID.x), line = int(gl_WorkGroupID.y);
    if (j >= kSamples) return;
    const vec4 row = depths[j].row;
    // Computes exp(-d^2 q) by a recurrence.
    const float q = 0.5 / (row.z * row.z), fall = exp(-2.0 * q);
    float weight = 1.0, ratio = exp(-q), total = 1.0;
    vec2 sum = unpackHalf2x16(field[line * kSamples + j]);
    const int taps = min(int(ceil(frame.reach.x * row.z)), kMaxBeamTaps);
    for (int d = 1; d <= taps; ++d) {
        weight *= ratio;
        ratio *= fall;
        if (line >= d) {
            sum += weight * unpackHalf2x16(field[(line - d) * kSamples + j]);
            total += weight;
        }
        if (line + d < kLines) {
            sum += weight * unpackHalf2x16(field[(line + d) * kSamples + j]);
            total += weight;
        }
    }
    sum /= total;
    const float drawn = float(j) * frame.march.y;
    if (frame.march.z > 0.0)
        sum += thermal(uint(frame.tone.z) * 0x9e3779b9u + uint(line * kSamples + j)) *
               (frame.march.z * exp(frame.march.w * drawn));
    const float e = length(sum);
    envelope[line * kSamples + j] = e;
    const float db = 8.685889638 * log(max(e * row.w, 1e-12));
    grey[line * kSamples + j] = clamp(1.0 + db / frame.tone.x, 0.0, 1.0);
}
