// All bindings of the scan's only descriptor set, in the order of ScanBinding in ultrasound.cpp.
#include "render/ultrasound/scan_shared.h"

layout(constant_id = 0) const int kSamples = 512;
layout(constant_id = 1) const int kLines = 256;
layout(constant_id = 2) const int kPlanes = 3;
layout(constant_id = 3) const bool kBreathes = true;  // look up the breath
layout(constant_id = 4) const bool kPressed = true;   // look up a tool's displacement
layout(constant_id = 5) const int kCoarse = 8;        // samples that share a look-up; 1: no sharing
layout(constant_id = 6) const bool kColour = false;   // Doppler
layout(constant_id = 7) const int kTaps = 6;          // taps of the pulse on either side, at most 6

layout(std140, set = 0, binding = 0) uniform Scan { ScanUniforms frame; };
layout(set = 0, binding = 1) uniform usampler3D voxels;
layout(set = 0, binding = 2) uniform sampler3D deform_inside;
layout(set = 0, binding = 3) uniform sampler3D deform_outside;
layout(set = 0, binding = 4) uniform sampler3D tool_moved;
layout(set = 0, binding = 5) uniform isampler3D flow;
layout(std430, set = 0, binding = 6) readonly buffer Lines { LineUniforms lines[]; };
layout(std430, set = 0, binding = 7) readonly buffer Depths { DepthUniforms depths[]; };
layout(std430, set = 0, binding = 8) buffer Places { vec4 places[]; };  // coarse grid: reference minus deformed, m
layout(std430, set = 0, binding = 9) buffer Samples { uvec4 samples[]; };  // plane, line, sample
layout(std430, set = 0, binding = 10) buffer Field { uint field[]; };  // line, bin: complex, two halves
// Line, bin: depth, m; remaining amplitude.
layout(std430, set = 0, binding = 11) buffer Propagation { vec2 propagation[]; };
layout(std430, set = 0, binding = 12) buffer Envelope { float envelope[]; };
layout(std430, set = 0, binding = 13) buffer Grey { float grey[]; };
// Velocity toward the probe, relative to the Nyquist velocity; how strongly it shows.
layout(std430, set = 0, binding = 14) buffer Doppler { vec2 doppler[]; };
layout(std430, set = 0, binding = 15) buffer Picture { uint picture[]; };
