// What the shaders of a fluoroscopy picture read. Included by C++ and by GLSL (std140): only vec4 and uvec4,
// so both lay it out alike.
#ifndef STYLET_RENDER_FLUOROSCOPY_SHARED_H
#define STYLET_RENDER_FLUOROSCOPY_SHARED_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/ext/vector_uint4.hpp>
#include <glm/vec4.hpp>

namespace stylet::render::gpu {
using glm::uvec4;
using glm::vec4;
using uint = std::uint32_t;
#endif

const int kXrayGroup = 8;  // a workgroup covers this many pixels along either axis
const int kToolParts = 3;  // of a stretch that a tool has displaced: as fine as its table
const int kMostShapes = 64;
const int kMeter = 64;  // the metered field is looked at on this lattice

struct ShapeUniforms {
    vec4 begin;     // patient frame, m; w: radius
    vec4 end;       // w: radius of the bore
    vec4 material;  // attenuation, 1/m; round, chained
};

struct XrayUniforms {
    vec4 source;  // patient frame, m; w: pixels a side
    vec4 first;   // middle of the upper left pixel; w: attenuation of water, 1/m
    vec4 right;   // from pixel to pixel; w: a pixel, m
    vec4 down;
    vec4 blades;    // open to the left, right, top, bottom of the middle, m on the detector
    vec4 iris;      // radius, m (0: none); shapes
    vec4 box_low;   // of what attenuates, deformed patient; w: longest stretch between two looks at the
                    // motion, m
    vec4 box_high;  // w: samples a stretch
    vec4 tissue_scale, tissue_offset;  // reference patient to texture coordinates
    vec4 cell_scale, cell_offset;      // and to cells
    vec4 deform_scale, deform_offset;  // deformed patient to the motion's tables
    vec4 tool_scale, tool_offset;
    ShapeUniforms shapes[kMostShapes];
};

// The picture from the line integrals.
struct ScreenUniforms {
    vec4 quanta;  // detected in a pixel that nothing shades; electronic noise; those of mid-grey; slope of
                  // the curve
    vec4 blades;  // as XrayUniforms
    vec4 iris;    // radius, m (0: none); a pixel, m; pixels a side; 1: dense is dark
    vec4 tone;  // share of the slow part that is taken out; mean path; pixels a cell of the lattice; cells a
                // side
    uvec4 noise;  // pulse (low, high), seed
};

struct XrayCounters {
    uint samples, samples_high, empty_stretches, collimated_rays;
};

#ifdef __cplusplus
inline int meterStride(int pixels) {
    return (pixels + kMeter - 1) / kMeter;
}
inline int meterSide(int pixels) {
    return (pixels + meterStride(pixels) - 1) / meterStride(pixels);
}

static_assert(sizeof(XrayUniforms) == (16 + 3 * kMostShapes) * 16);
static_assert(sizeof(ScreenUniforms) == 80);
}  // namespace stylet::render::gpu
#endif
#endif
