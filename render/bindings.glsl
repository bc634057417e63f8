// Descriptor set 0 of every pipeline.
#include "render/frame_shared.h"

layout(std140, set = 0, binding = 0) uniform Frame { FrameUniforms frame; };
layout(std140, set = 0, binding = 1) uniform LookBlock { LookUniforms look; };
layout(set = 0, binding = 2) uniform sampler3D classified;       // opacity-weighted colour, see classified.h
layout(set = 0, binding = 3) uniform sampler2DArray mesh_depth;  // reversed, one layer an eye
layout(std430, set = 0, binding = 4) readonly buffer Bricks { uint brick_distance[]; };
layout(set = 0, binding = 5) uniform sampler3D deform_inside;    // see deform.h
layout(std430, set = 0, binding = 6) buffer Count { Counters counters; };
layout(set = 0, binding = 7) uniform sampler3D deform_outside;
