#version 460
#extension GL_GOOGLE_include_directive : require

// Looks up one voxel and one point of the scatterers' lattice for each sample of each line and plane.
layout(local_size_x = 64) in;
#include "render/ultrasound/bindings.glsl"
#include "render/ultrasound/places.glsl"
#include "render/ultrasound/sample.glsl"

vec3 samplePosition(int line, int i, int plane) {
    if (!kBreathes && !kPressed) return sampleAt(line, float(i), plane);
    if (kCoarse == 1) return referencePosition(sampleAt(line, float(i), plane));
    const int column = i / kCoarse, row = line / kCoarseLines;
    const float u = float(i - column * kCoarse) / float(kCoarse);
    return sampleAt(line, float(i), plane) + mix(shiftOnGrid(line, column, plane), shiftOnGrid(line, column + 1, plane), u);
}

void main() {
    const int i = int(gl_GlobalInvocationID.x), line = int(gl_WorkGroupID.y), plane = int(gl_WorkGroupID.z);
    if (i >= kSamples || lines[line].direction.w < 0.0) return;
    const Sample s = sampleAtPlace(samplePosition(line, i, plane), lines[line].direction.xyz, float(i) * frame.march.x,
                                   lines[line].origin.w);
    const uint turn = uint(clamp((s.crossing / kCrossingRange + 1.0) * 511.5, 0.0, 1023.0));
    const uint facing = s.facing < 0.0 ? 0u : uint(min(s.facing, 1.0) * 254.0) + 1u;
    samples[(plane * kLines + line) * kSamples + i] =
        uvec4(s.tissue | turn << kCrossingAt | facing << kFacingAt | uint(s.fluid * 255.0 + 0.5) << kFluidAt, packHalf2x16(s.noise), floatBitsToUint(s.impedance),
              floatBitsToUint(s.scatter));
}
