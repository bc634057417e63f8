// Data that the shaders of a fluoroscopy picture read. Included by C++ and by GLSL (std140). Uses only vec4
// and uvec4, so that the layout is the same in both.
#ifndef STYLET_RENDER_FLUOROSCOPY_SHARED_H
#define STYLET_RENDER_FLUOROSCOPY_SHARED_H

#include "render/scene/shader_types.h"

#ifdef __cplusplus
namespace stylet::render::gpu {
#endif

const int kXrayGroup = 8;  // pixels that a workgroup covers along either axis
const int kToolParts = 3;  // parts of a segment near a tool; about one node of the tool's table each
const int kMaxShapes = 128;
const int kMeter = 64;  // cells per side of the lattice on which the picture is metered

struct ShapeUniforms {
    vec4 begin;     // patient frame, m; w: radius
    vec4 end;       // w: radius of the bore
    vec4 material;  // attenuation, 1/m; round, chained
};

struct XrayUniforms {
    vec4 source;  // patient frame, m; w: pixels per side
    vec4 first;   // middle of the upper left pixel; w: attenuation of water, 1/m
    vec4 right;   // step from pixel to pixel; w: size of a pixel, m
    vec4 down;
    vec4 blades;  // open to the left, right, top, bottom of the middle, m on the detector
    vec4 iris;    // radius, m (0: none); number of shapes; pixels per cell of the metered lattice
    // Box of all attenuation in the deformed patient; w: longest segment between two look-ups of the motion,
    // m.
    vec4 box_low;
    vec4 box_high;                     // w: samples per segment
    vec4 tissue_scale, tissue_offset;  // reference patient to texture coordinates
    vec4 cell_scale, cell_offset;      // and to cells
    vec4 deform_scale, deform_offset;  // deformed patient to the motion's tables
    vec4 tool_scale, tool_offset;
    ShapeUniforms shapes[kMaxShapes];
};

// Parameters of screen.comp.
struct ScreenUniforms {
    // Quanta detected in an unattenuated pixel; electronic noise; quanta of mid-grey; slope of the curve.
    vec4 quanta;
    vec4 blades;  // as in XrayUniforms
    vec4 iris;    // radius, m (0: none); size of a pixel, m; pixels per side; 1: dense is dark
    // Share of the low-frequency part that is removed; mean line integral; pixels per cell of the lattice;
    // cells per side.
    vec4 tone;
    uvec4 noise;  // pulse (low, high), seed
};

struct XrayCounters {
    uint samples, samples_high, empty_segments, collimated_rays;
};

#ifdef __cplusplus
inline int meterStride(int pixels) {
    return (pixels + kMeter - 1) / kMeter;
}
inline int meterSide(int pixels) {
    return (pixels + meterStride(pixels) - 1) / meterStride(pixels);
}

static_assert(sizeof(XrayUniforms) == (16 + 3 * kMaxShapes) * 16);
static_assert(sizeof(ScreenUniforms) == 80);
}  // namespace stylet::render::gpu
#endif
#endif
