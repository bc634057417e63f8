#version 460
#extension GL_GOOGLE_include_directive : require
// Line integrals of the attenuation from the source to every pixel: the exponent of Beer-Lambert's law.
//
// Each ray is divided into stretches (FluoroscopySettings::segment_m). The motion is looked up at their ends
// and interpolated linearly between them. If a stretch crosses the cavity's wall, each side has its own line.
// The tissue is sampled at several equal steps per stretch.
// Some loops replace branches: a SIMD machine with masked branches executes both sides of a branch, but skips
// a loop that no lane enters.
#include "render/fluoroscopy/fluoroscopy_shared.h"

layout(constant_id = 0) const uint kDeform = 0;
layout(constant_id = 1) const uint kTool = 0;
layout(constant_id = 2) const uint kEmptyCells = 1;
layout(constant_id = 3) const uint kCollimate = 1;
layout(constant_id = 4) const uint kCount = 0;
layout(constant_id = 5) const int kBlock = 2;

const int kRays = kBlock * kBlock;  // rays per invocation, for neighbouring pixels

layout(local_size_x = kXrayGroup, local_size_y = kXrayGroup) in;

// Named `frame` because deform.glsl reads the motion's scales from `frame`. Not a uniform block: lavapipe (of
// Mesa 22) recompiles the shader whenever the values of a uniform block change, and caches only the last
// version.
layout(std430, binding = 0) readonly buffer Uniforms { XrayUniforms frame; };
layout(binding = 1) uniform sampler3D tissue;
layout(binding = 2) uniform usampler3D cells;
layout(binding = 3) uniform sampler3D deform_inside;
layout(binding = 4) uniform sampler3D deform_outside;
layout(binding = 5) uniform sampler3D tool_moved;
layout(std430, binding = 6) writeonly buffer Paths { float paths[]; };
layout(std430, binding = 7) writeonly buffer Meter { float meter[]; };
layout(std430, binding = 8) buffer Counts { XrayCounters counters; };

#include "render/fluoroscopy/chords.glsl"
#include "render/volume/deform.glsl"
#include "render/fluoroscopy/collimation.glsl"

// Reference positions of a point of the displaced patient, computed for both sides of the cavity's wall. The
// sign of `level` selects the valid one.
struct Node {
    vec3 inside, outside;  // reference patient
    float level;           // < 0 in the cavity
};

Node nodeAt(vec3 p) {
    if (kTool != 0) p -= toolMoved(p);
    if (kDeform == 0) return Node(p, p, 1.0);
    const vec3 at = p * frame.deform_scale.xyz + frame.deform_offset.xyz;
    const vec4 inside = textureLod(deform_inside, at, 0.0);
    return Node(p + inside.xyz, p + textureLod(deform_outside, at, 0.0).xyz, inside.w);
}

bool isOccupied(vec3 reference) {
    const ivec3 last = textureSize(cells, 0) - 1;
    const ivec3 cell = ivec3(floor(reference * frame.cell_scale.xyz + frame.cell_offset.xyz));
    return texelFetch(cells, clamp(cell, ivec3(0), last), 0).r != 0;
}

// Reference minus deformed position along a stretch, linear from its start (0) to its end (1). The line from
// a0 to a1 is for the side of the cavity's wall where the stretch begins. The line from b0 to b1 is for the
// side where it ends, and applies from `change` on.
struct Shift {
    vec3 a0, a1, b0, b1;
    float change;
};

// True if a stretch comes near the tissue that a tool displaces.
bool nearTool(vec3 from, vec3 to) {
    const vec3 a = from * frame.tool_scale.xyz + frame.tool_offset.xyz;
    const vec3 b = to * frame.tool_scale.xyz + frame.tool_offset.xyz;
    return all(lessThan(min(a, b), vec3(1.0))) && all(greaterThan(max(a, b), vec3(0.0)));
}

// The rays of a block: the point where each enters the patient's box, and its path over one stretch.
vec3 entry[kRays], along[kRays];
// Position of a sample within its step, 0 to 1. It differs from block to block, so that steps longer than a
// voxel cause grain instead of bands. This grain is finer and fainter than the quantum noise.
float place;

// Adds the samples of one part of stretch `i` to each ray's sum. A stretch has `parts` parts and `count`
// samples.
void addSamples(int i, int part, int parts, Shift shift, int count, inout float sums[kRays]) {
    const vec3 scale = frame.tissue_scale.xyz, offset = frame.tissue_offset.xyz;
    const vec3 a = shift.a0 * scale + offset, a_step = (shift.a1 - shift.a0) * scale;
    const vec3 b = shift.b0 * scale + offset, b_step = (shift.b1 - shift.b0) * scale;
    const int taken = count / parts;
    float f = place / float(taken);
    for (int k = 0; k < taken; ++k) {
        const vec3 shifted = kDeform == 0 || f < shift.change ? a + f * a_step : b + f * b_step;
        const float t = float(i) + (float(part) + f) / float(parts);
        for (int r = 0; r < kRays; ++r)
            sums[r] += textureLod(tissue, shifted + (entry[r] + t * along[r]) * scale, 0.0).r;
        f += 1.0 / float(taken);
    }
}

// True if nothing attenuates around the middle of a stretch and no tool presses there.
bool isEmpty(vec3 from, vec3 to) {
    if (kTool != 0 && nearTool(from, to)) return false;
    const vec3 middle = 0.5 * (from + to);
    const Node n = nodeAt(middle);
    bool occupied = isOccupied(n.outside);
    if (kDeform != 0) occupied = occupied || isOccupied(n.inside);
    return !occupied;
}

// Finds the block's rays. Returns the number of stretches per ray, 0 if no ray meets the patient. `lengths`:
// length of each ray's stretch, m.
int findRays(ivec2 pixel, out float lengths[kRays]) {
    const vec3 origin = frame.source.xyz;
    float longest = 0.0;
    for (int r = 0; r < kRays; ++r) {
        const ivec2 at = pixel + ivec2(r % kBlock, r / kBlock);
        const vec3 ray = frame.first.xyz + float(at.x) * frame.right.xyz + float(at.y) * frame.down.xyz - origin;
        const float reach = length(ray);
        const vec3 direction = ray / reach;
        const vec3 inverse = 1.0 / mix(direction, vec3(1e-9), lessThan(abs(direction), vec3(1e-9)));
        const vec3 ta = (frame.box_low.xyz - origin) * inverse, tb = (frame.box_high.xyz - origin) * inverse;
        const vec3 low = min(ta, tb), high = max(ta, tb);
        const float begin = max(max(low.x, max(low.y, low.z)), 0.0);
        lengths[r] = max(min(min(high.x, min(high.y, high.z)), reach) - begin, 0.0);
        entry[r] = origin + begin * direction;
        along[r] = lengths[r] * direction;
        longest = max(longest, lengths[r]);
    }
    const int stretches = int(ceil(longest / frame.box_low.w));
    for (int r = 0; r < kRays; ++r) {
        lengths[r] /= max(float(stretches), 1.0);
        along[r] /= max(float(stretches), 1.0);
    }
    return stretches;
}

// Line integrals of the attenuation relative to water for the block's rays, m.
void patientPaths(ivec2 pixel, out float sums[kRays]) {
    float lengths[kRays];
    const int stretches = findRays(pixel, lengths);
    const int samples = int(frame.box_high.w);
    // The motion is looked up along the mean of the rays that meet the patient.
    vec3 from = vec3(0.0), way = vec3(0.0);
    float hits = 0.0;
    for (int r = 0; r < kRays; ++r) {
        sums[r] = 0.0;
        const float hit = lengths[r] > 0.0 ? 1.0 : 0.0;
        from += hit * entry[r], way += hit * along[r], hits += hit;
    }
    from /= max(hits, 1.0), way /= max(hits, 1.0);

    // Skip the air before and behind the patient.
    int first = 0, last = stretches;
    for (bool empty = kEmptyCells != 0; empty && first < last;) {
        empty = isEmpty(from + float(first) * way, from + float(first + 1) * way);
        first += empty ? 1 : 0;
    }
    for (bool empty = kEmptyCells != 0; empty && first < last;) {
        empty = isEmpty(from + float(last - 1) * way, from + float(last) * way);
        last -= empty ? 1 : 0;
    }

    vec3 p0 = from + float(first) * way;
    Node n0 = nodeAt(p0);
    for (int i = first; i < last; ++i) {
        const bool tool = kTool != 0 && nearTool(p0, from + float(i + 1) * way);
        const int parts = tool ? kToolParts : 1;
        for (int part = 0; part < parts; ++part) {
            const vec3 p1 = from + (float(i) + float(part + 1) / float(parts)) * way;
            const Node n1 = nodeAt(p1);
            const bool in0 = n0.level < 0.0, in1 = n1.level < 0.0;
            const Shift shift = Shift((in0 ? n0.inside : n0.outside) - p0, (in0 ? n1.inside : n1.outside) - p1,
                                      (in1 ? n0.inside : n0.outside) - p0, (in1 ? n1.inside : n1.outside) - p1,
                                      in0 == in1 ? 2.0 : n0.level / (n0.level - n1.level));
            addSamples(i, part, parts, shift, samples, sums);
            p0 = p1;
            n0 = n1;
        }
    }
    for (int r = 0; r < kRays; ++r)
        sums[r] *= lengths[r] / float(samples);
    if (kCount != 0) {
        const uint taken = uint((last - first) * samples * kRays);
        if (atomicAdd(counters.samples, taken) > 0xffffffffu - taken) atomicAdd(counters.samples_high, 1);
        atomicAdd(counters.empty_segments, uint(stretches - (last - first)) * uint(kRays));
    }
}

float openAt(ivec2 pixel) {
    return openShare(frame.blades, frame.iris.x, (vec2(pixel) + 0.5 - 0.5 * frame.source.w) * frame.right.w, frame.right.w);
}

void store(ivec2 pixel, float path) {
    const int pixels = int(frame.source.w);
    if (any(greaterThanEqual(pixel, ivec2(pixels)))) return;
    paths[pixel.y * pixels + pixel.x] = path;
    // The meter reads only a few pixels.
    const int stride = int(frame.iris.z);
    const ivec2 cell = pixel / stride;
    if (all(equal(pixel, cell * stride))) meter[cell.y * kMeter + cell.x] = openAt(pixel) > 0.0 ? path : -1.0;
}

void main() {
    const ivec2 block = ivec2(gl_GlobalInvocationID.xy) * kBlock;
    if (any(greaterThanEqual(block, ivec2(frame.source.w)))) return;
    bool open = kCollimate == 0;
    for (int r = 0; r < kRays; ++r)
        open = open || openAt(block + ivec2(r % kBlock, r / kBlock)) > 0.0;
    if (!open) {
        for (int r = 0; r < kRays; ++r)
            store(block + ivec2(r % kBlock, r / kBlock), 0.0);
        if (kCount != 0) atomicAdd(counters.collimated_rays, uint(kRays));
        return;
    }
    // Interleaved gradient noise: Jimenez, "Next generation post processing in Call of Duty", 2014.
    place = fract(52.9829189 * fract(dot(vec2(gl_GlobalInvocationID.xy), vec2(0.06711056, 0.00583715))));
    float water_m[kRays];
    patientPaths(block, water_m);
    for (int r = 0; r < kRays; ++r) {
        const ivec2 pixel = block + ivec2(r % kBlock, r / kBlock);
        const vec3 ray = frame.first.xyz + float(pixel.x) * frame.right.xyz + float(pixel.y) * frame.down.xyz - frame.source.xyz;
        const float reach = length(ray);
        store(pixel, frame.first.w * water_m[r] + shapesPath(frame.source.xyz, ray / reach, reach));
    }
}
