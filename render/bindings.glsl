// Descriptor set 0 of every pipeline.
#include "render/frame_shared.h"
#include "render/room/room_shared.h"

layout(std140, set = 0, binding = 0) uniform Frame { FrameUniforms frame; };
layout(std140, set = 0, binding = 1) uniform LookBlock { LookUniforms look; };
layout(set = 0, binding = 2) uniform sampler3D classified;       // opacity-weighted colour, see classified.h
layout(set = 0, binding = 3) uniform sampler2DArray mesh_depth;  // reversed, one layer an eye
layout(std430, set = 0, binding = 4) readonly buffer Bricks { uint brick_distance[]; };
layout(set = 0, binding = 5) uniform sampler3D deform_inside;    // see deform.h
layout(std430, set = 0, binding = 6) buffer Count { Counters counters; };
layout(set = 0, binding = 7) uniform sampler3D deform_outside;
layout(set = 0, binding = 8, rgba16f) uniform image2DArray layer_colour;  // linear, premultiplied; an eye a layer
layout(set = 0, binding = 9, r32f) uniform image2DArray layer_depth;      // m along the eye's -z of the first surface; 0 = none
layout(set = 0, binding = 10) uniform sampler3D tool_moved;        // see deform.glsl
layout(std140, set = 0, binding = 11) uniform RoomBlock { RoomUniforms room; };
layout(set = 0, binding = 12) uniform sampler2DArray environment;       // octahedral, a roughness a layer: environment.h
layout(set = 0, binding = 13) uniform sampler2DArrayShadow lamp_shadow;  // reversed depth, seen from the lamp
layout(set = 0, binding = 14) uniform sampler2DArray screens;           // ultrasound, X-ray, monitor
