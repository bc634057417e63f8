#version 460
#extension GL_GOOGLE_include_directive : require

// Colour Doppler on a grid of its own inside the box: the blood's velocity along the beam, averaged over a
// sample volume and aliased at the Nyquist velocity. A wall filter removes slow motion. Based on Kasai et al.
// 1985, IEEE Trans Sonics Ultrason 32:458 (mean phase shift from pulse to pulse).
layout(local_size_x = 64) in;
#include "render/ultrasound/bindings.glsl"
#include "render/ultrasound/places.glsl"

const float kTurn = 6.283185307;
const float kDopplerSensitivity = 10.0;  // 20 dB more sensitive than the grey picture, because it averages pulses

void main() {
    const int row = int(gl_GlobalInvocationID.x), column = int(gl_GlobalInvocationID.y);
    const int columns = int(frame.flow_look.z), rows = int(frame.flow_look.w);
    if (row >= rows) return;
    const float share = mix(frame.doppler.x, frame.doppler.y, float(column) / float(columns - 1));
    const float drawn = mix(frame.doppler.z, frame.doppler.w, float(row) / float(rows - 1));
    const int line = clamp(int(share * float(kLines - 1) + 0.5), 0, kLines - 1);
    const int bin = clamp(int(drawn / frame.march.y + 0.5), 0, kSamples - 1);
    const vec2 here = propagation[line * kSamples + bin];
    vec2 turned = vec2(0.0);  // the mean phasor: autocorrelation at one pulse's lag
    if (here.y > 0.0)
        for (int plane = 0; plane < kPlanes; ++plane)
            for (int d = -1; d <= 1; ++d) {
                const int beside = clamp(line + d * max(kLines / 128, 1), 0, kLines - 1);
                const vec3 p = sampleAt(beside, here.x / frame.march.x, plane);
                const vec3 at = referencePosition(p) * frame.flow_scale.xyz + frame.flow_offset.xyz;
                const ivec3 cell = ivec3(floor(at + 0.5));
                if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, ivec3(frame.flow_dims.xyz)))) continue;
                const ivec4 blood = texelFetch(flow, cell, 0);
                const int kind = int(float(blood.w) / kFlowKindStep + 0.5);
                if (kind <= 0) continue;
                const vec3 v = vec3(blood.xyz) * (frame.flow_scale.w * frame.pulses[kind / 4][kind % 4] / kFlowUnit);
                // Toward the probe is positive.
                const float along = -dot(v, lines[beside].direction.xyz), wall = frame.flow_look.x;
                const float passed = wall > 0.0 ? smoothstep(0.5, 1.0, abs(along) / wall) : 1.0;
                const float angle = 0.5 * kTurn * along / frame.flow_offset.w;
                turned += frame.planes[plane].y * (1.0 / 3.0) * passed * vec2(cos(angle), sin(angle));
            }
    const float power = length(turned);
    const float heard = min(here.y * frame.flow_look.y * kDopplerSensitivity, 1.0);
    doppler[column * rows + row] = vec2(atan(turned.y, turned.x) * (2.0 / kTurn), power > 0.0 ? power * heard : 0.0);
}
