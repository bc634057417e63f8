#version 460
#extension GL_GOOGLE_include_directive : require

// Each invocation computes one line, from the face down. For devices with few lanes and slow memory, such as
// a processor. Gives the same echoes as tissue.comp and line.comp, which compute a line by prefix sums.
layout(local_size_x = 8) in;
#include "render/ultrasound/bindings.glsl"
#include "render/ultrasound/places.glsl"
#include "render/ultrasound/sample.glsl"

const int kReach = 2;

vec3 shift_from, shift_to;  // displacements at both ends of the samples that share a look-up

vec3 samplePosition(int line, int i, int plane) {
    if (!kBreathes && !kPressed) return sampleAt(line, float(i), plane);
    if (kCoarse == 1) return referencePosition(sampleAt(line, float(i), plane));
    const int column = i / kCoarse;
    if (i % kCoarse == 0) {
        shift_from = column == 0 ? shiftOnGrid(line, 0, plane) : shift_to;
        shift_to = shiftOnGrid(line, column + 1, plane);
    }
    return sampleAt(line, float(i), plane) + mix(shift_from, shift_to, float(i - column * kCoarse) / float(kCoarse));
}

void main() {
    const int line = int(gl_GlobalInvocationID.x);
    if (line >= kLines) return;
    const vec4 direction = lines[line].direction, needle = lines[line].needle;
    const float gel_m = lines[line].origin.w, bin = frame.march.y, per_bin = 1.0 / bin;
    if (direction.w < 0.0) {
        for (int j = 0; j < kSamples; ++j) {
            field[line * kSamples + j] = packHalf2x16(vec2(rings(float(j) * bin), 0.0));
            if (kColour) propagation[line * kSamples + j] = vec2(0.0);
        }
        return;
    }
    vec2 needle_at = vec2(1e6, 0.0);
    for (int turn = 0; turn < kPlanes; ++turn) {
        // Start with the middle plane: it gives the position of the needle.
        const int plane = turn == 0 ? kPlanes / 2 : turn - (turn <= kPlanes / 2 ? 1 : 0);
        const float weight = frame.planes[plane].y;
        vec2 open[2 * kReach + 1];  // echoes of the bins around the next one
        for (int i = 0; i <= 2 * kReach; ++i) open[i] = vec2(0.0);
        vec2 past[2 * kTaps + 1];  // echoes of the bins before, for the pulse
        for (int i = 0; i <= 2 * kTaps; ++i) past[i] = vec2(0.0);
        float t = 0.0, left = 1.0;
        int j = 0;
        Sample a = sampleAtPlace(samplePosition(line, 0, plane), direction.xyz, 0.0, gel_m);
        const int end = kSamples + kReach + kTaps;
        for (int k = 0; k < 3 * kSamples && j < end; ++k) {
            // Beyond the last sample no new echoes are added; only the pending bins are completed.
            const bool marched = k < kSamples;
            Sample b = a;
            if (k + 1 < kSamples)
                b = sampleAtPlace(samplePosition(line, k + 1, plane), direction.xyz, float(k + 1) * frame.march.x, gel_m);
            const Step s = stepBetween(a, b);
            const float jump_at = t + a.drawn * s.share, x = jump_at * per_bin - float(j);
            for (int i = 0; i <= 2 * kReach; ++i)
                open[i].x += s.mirrored * left * frame.pulse[0].y * clamp(1.5 - abs(x - float(i - kReach)), 0.0, 1.0);
            const float needle_step = needle.x / frame.march.x - float(k);
            if (turn == 0 && needle.x > 0.0 && needle_step >= 0.0 && needle_step < 1.0)
                needle_at = vec2(t + s.drawn * needle_step, left);
            while (float(j) * bin < t + s.drawn && j < end) {
                const float here = float(j) * bin;
                const bool after = here >= jump_at;
                const float here_left = after ? left * s.passes : left;
                const float grains = ((after ? b.scatter : a.scatter) + frame.voxel_scale.w * abs(s.jump)) * here_left;
                const float share = (here - t) / s.drawn;
                if (marched && j < kSamples)
                    open[kReach] += noiseBetween(a.noise, b.noise, share) * (grains * depths[min(j, kSamples - 1)].row.y);
                if (kColour && turn == 0 && marched && j < kSamples)
                    propagation[line * kSamples + j] = vec2((float(k) + share) * frame.march.x, here_left);
                for (int i = 0; i < 2 * kTaps; ++i) past[i] = past[i + 1];
                past[2 * kTaps] = open[0];
                for (int i = 0; i < 2 * kReach; ++i) open[i] = open[i + 1];
                open[2 * kReach] = vec2(0.0);
                const int done = j - kReach - kTaps;
                if (done >= 0) {
                    vec2 sum = past[kTaps] * frame.pulse[0].x;
                    for (int d = 1; d <= kTaps; ++d) sum += (past[kTaps - d] + past[kTaps + d]) * frame.pulse[d].x;
                    const float drawn = float(done) * bin;
                    sum *= weight * needleShadow(needle, needle_at, drawn);
                    if (turn == 0 && needle.y > 0.0) sum.x += needleEcho(needle, needle_at, drawn);
                    sum *= direction.w;
                    if (turn != 0) sum += unpackHalf2x16(field[line * kSamples + done]);
                    field[line * kSamples + done] = packHalf2x16(sum);
                }
                ++j;
            }
            t += s.drawn;
            left *= marched ? s.passes : 0.0;
            a = b;
        }
    }
}
