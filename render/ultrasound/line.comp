#version 460
#extension GL_GOOGLE_include_directive : require

// Each workgroup computes one line. Prefix sums along the line give arrival times and remaining amplitudes.
// Then the echoes of all planes are summed coherently in bins of drawn depth, and the pulse is applied.
layout(local_size_x = 64) in;
#include "render/ultrasound/bindings.glsl"
#include "render/ultrasound/sample.glsl"

const int kThreads = 64, kChunk = (kSamples + kThreads - 1) / kThreads;

shared float jump_at[kSamples];   // drawn depth of the change between a sample and the next
shared float mirrored[kSamples];  // amplitude that this change reflects
shared float field_x[kSamples], field_y[kSamples];
shared vec2 parts[kThreads];  // per thread, for its stretch: drawn length, share of the amplitude that passes
shared vec2 needle_at;        // at the needle: drawn depth, remaining amplitude

Sample sampleIn(int base, int i) {
    const uvec4 bits = samples[base + min(i, kSamples - 1)];
    const uint tissue = bits.x & 31u, facing = bits.x >> kFacingAt & 255u;
    const float fluid = float(bits.x >> kFluidAt & 255u) * (1.0 / 255.0);
    const vec4 mean = soakedMean(tissue, fluid);
    return Sample(tissue, fluid, uintBitsToFloat(bits.z), uintBitsToFloat(bits.w),
                  (float(bits.x >> kCrossingAt & 1023u) * (1.0 / 511.5) - 1.0) * kCrossingRange,
                  facing == 0u ? -1.0 : float(facing - 1u) * (1.0 / 254.0), mean.y, mean.z, unpackHalf2x16(bits.y));
}

// Drawn depth and remaining amplitude at the start and at the end of this thread's stretch.
void prefix(int base, int from, int to, out vec2 first, out vec2 last) {
    vec2 part = vec2(0.0, 1.0);
    Sample a = sampleIn(base, from);
    for (int k = from; k < to; ++k) {
        const Sample b = sampleIn(base, k + 1);
        const Step s = stepBetween(a, b);
        part = vec2(part.x + s.drawn, part.y * s.passes);
        a = b;
    }
    const int me = int(gl_LocalInvocationID.x);
    parts[me] = part;
    barrier();
    first = vec2(0.0, 1.0);
    for (int i = 0; i < me; ++i) first = vec2(first.x + parts[i].x, first.y * parts[i].y);
    last = vec2(first.x + part.x, first.y * part.y);
}

void markJumps(int base, vec4 needle, int from, int to, vec2 at) {
    Sample a = sampleIn(base, from);
    for (int k = from; k < to; ++k) {
        const Sample b = sampleIn(base, k + 1);
        const Step s = stepBetween(a, b);
        const float needle_step = needle.x / frame.march.x - float(k);
        if (needle.x > 0.0 && needle_step >= 0.0 && needle_step < 1.0)
            needle_at = vec2(at.x + s.drawn * needle_step, at.y);
        jump_at[k] = at.x + a.drawn * s.share;
        mirrored[k] = s.mirrored * at.y;
        at = vec2(at.x + s.drawn, at.y * s.passes);
        a = b;
    }
}

// Adds echoes and noise to the bins that lie within this thread's stretch.
void addBins(int base, int line, int from, int to, vec2 at, float end, float weight, bool middle) {
    const float bin = frame.march.y;
    int j = int(ceil(at.x / bin)), k = from;
    const int stop = min(int(ceil(end / bin)), kSamples);
    Sample a = sampleIn(base, from), b = sampleIn(base, from + 1);
    Step s = stepBetween(a, b);
    for (; j < stop; ++j) {
        const float t = float(j) * bin;
        while (k + 1 < to && t >= at.x + s.drawn) {
            at = vec2(at.x + s.drawn, at.y * s.passes);
            a = b;
            b = sampleIn(base, ++k + 1);
            s = stepBetween(a, b);
        }
        float echo = 0.0;
        for (int m = k; m >= 0 && t - jump_at[m] < 1.5 * bin; --m)
            echo += mirrored[m] * clamp(1.5 - abs(t - jump_at[m]) / bin, 0.0, 1.0);
        for (int m = k + 1; m < kSamples && jump_at[m] - t < 1.5 * bin; ++m)
            echo += mirrored[m] * clamp(1.5 - abs(t - jump_at[m]) / bin, 0.0, 1.0);
        const bool after = t >= jump_at[k];
        const float left = after ? at.y * s.passes : at.y;
        const float grains = ((after ? b.scatter : a.scatter) + frame.voxel_scale.w * abs(s.jump)) * left;
        const float share = (t - at.x) / s.drawn;
        const vec2 noise = noiseBetween(a.noise, b.noise, share) * (grains * depths[j].row.y);
        field_x[j] += weight * (echo * frame.pulse[0].y + noise.x);
        field_y[j] += weight * noise.y;
        if (kColour && middle) propagation[line * kSamples + j] = vec2((float(k) + share) * frame.march.x, left);
    }
}

vec2 pulsed(int j) {
    vec2 sum = vec2(field_x[j], field_y[j]) * frame.pulse[0].x;
    for (int d = 1; d <= kTaps; ++d) {
        if (j >= d) sum += vec2(field_x[j - d], field_y[j - d]) * frame.pulse[d].x;
        if (j + d < kSamples) sum += vec2(field_x[j + d], field_y[j + d]) * frame.pulse[d].x;
    }
    return sum;
}

void main() {
    const int line = int(gl_WorkGroupID.x), me = int(gl_LocalInvocationID.x);
    const float coupling = lines[line].direction.w;
    for (int j = me; j < kSamples; j += kThreads) {
        field_x[j] = field_y[j] = 0.0;
        if (kColour) propagation[line * kSamples + j] = vec2(0.0);
        if (coupling < 0.0) field[line * kSamples + j] = packHalf2x16(vec2(rings(float(j) * frame.march.y), 0.0));
    }
    if (coupling < 0.0) return;
    if (me == 0) needle_at = vec2(1e6, 0.0);
    memoryBarrierBuffer();
    const vec4 needle = lines[line].needle;
    const int from = min(me * kChunk, kSamples), to = min(from + kChunk, kSamples);
    for (int plane = 0; plane < kPlanes; ++plane) {
        const int base = (plane * kLines + line) * kSamples;
        const bool middle = plane == kPlanes / 2;
        vec2 first, last;
        prefix(base, from, to, first, last);
        markJumps(base, middle ? needle : vec4(0.0), from, to, first);
        barrier();
        if (from < to) addBins(base, line, from, to, first, last.x, frame.planes[plane].y, middle);
        barrier();
    }
    for (int j = me; j < kSamples; j += kThreads) {
        const float t = float(j) * frame.march.y;
        vec2 sum = pulsed(j) * needleShadow(needle, needle_at, t);
        if (needle.y > 0.0) sum.x += needleEcho(needle, needle_at, t);
        field[line * kSamples + j] = packHalf2x16(sum * coupling);
    }
}
