// Data that the passes of a scan read. Included by C++ and by GLSL (std140, std430). Uses only vec4 and
// uvec4, so that the layout is the same in both.
#ifndef STYLET_RENDER_ULTRASOUND_SCAN_SHARED_H
#define STYLET_RENDER_ULTRASOUND_SCAN_SHARED_H

#include "render/scene/shader_types.h"

#ifdef __cplusplus
namespace stylet::render::gpu {
#endif

const int kMaxTissues = 32, kMaxPlanes = 17, kMaxTaps = 6, kMaxDepots = 32;
// Packed voxels (acoustic_volume.h) and packed samples of the march: offsets in bits.
const int kOtherAt = 5, kNearAt = 10, kNormalXAt = 16, kNormalYAt = 22, kVariationAt = 28;
const int kCrossingAt = 5, kFacingAt = 15, kFluidAt = 23;
const float kNearRange = 0.875;    // voxels
const float kCrossingRange = 2.0;  // steps in either direction
// Scale that gives each part of a node's noise a variance of 1/2. The sum of two bytes has a variance of
// 2 (256^2 - 1) / 12.
const float kScattererScale = 0.0067658;
// Injected fluid: the largest share of it in tissue; the distances from the centre, in radii of its ball,
// between which the share falls to 0; how far its lobes stand out; their wave number, 1/m. Own estimates: the
// fluid in all is the ball's to 15 %, and the lobes are about a centimetre wide.
const float kMostFluid = 0.9, kFluidFrom = 0.75, kFluidTo = 1.25, kLobeHeight = 0.35, kLobesPer_m = 400.0;
// Comet tail of a needle: share of its echo, decay length to 1/e.
const float kComet = 0.30, kComet_m = 0.0035;
const float kUnknownFacing = 0.6;                         // |cos| for a change of impedance without a border
const float kFlowUnit = 32767.0, kFlowKindStep = 6000.0;  // patient/contrast/vessel_flow.h

struct AcousticUniforms {
    vec4 mean;  // ln impedance; two-way amplitude that a step passes; drawn length of a step, m; scatter
    // Change for a CT value one span higher: ln impedance, ln scatter. Wall: amplitude, thickness in m.
    vec4 variation;
};

struct ScanUniforms {
    vec4 deform_scale, deform_offset;  // as in frame_shared.h
    vec4 tool_scale, tool_offset;
    vec4 voxel_scale;   // patient frame to voxels; w: roughness
    vec4 voxel_offset;  // w: index of air
    vec4 voxel_dims;    // w: index of gel
    vec4 across;        // the probe's +y in the patient frame; w: 1 / spacing of the scatterers, 1/m
    vec4 lattice[3];    // rows of the rotation from the patient frame to the scatterers' lattice
    vec4 march;  // step, m; drawn bin, m; amplitude of electronic noise; amplification, neper per drawn m
    vec4 pulse[kMaxTaps + 1];  // x: taps, from the middle; y: factor that makes a mirror's echo 1
    vec4 rings;                // rings in air: period and decay, drawn m; amplitude
    vec4 tone;                 // dynamic range, dB; gain; number of the picture; 1: a guide is drawn
    vec4 planes[kMaxPlanes];   // x: offset in standard deviations of the beam's thickness; y: weight
    vec4 probe;                // convex 0, linear 1; radius; half-angle; half-width, m
    vec4 view;                 // picture: m per pixel; left, top in m; depth, m
    vec4 guide;                // start and end in the picture's plane, m
    vec4 marks;                // focus, m; spacing of the ticks, m; picture's width, height, pixels
    vec4 doppler;              // box: lines from, to (shares 0..1), depths from, to, m
    vec4 flow_scale;           // patient frame to voxels of the flow; w: unit of the flow, m/s
    vec4 flow_offset;          // w: Nyquist velocity, m/s
    vec4 flow_dims;            // voxels
    vec4 flow_look;            // wall filter, m/s; gain; columns and rows of the Doppler grid
    vec4 pulses[2];  // factor of the heartbeat for each kind of vessel (patient/contrast/vessel_flow.h)
    // Summed beam width, standard deviations; correlation of the noise one step apart; creep of the gel, m.
    vec4 reach;               // w: number of depots
    vec4 depots[kMaxDepots];  // injected fluid, reference patient: centre; radius of its ball, m
    uvec4 dry;                // x: bit mask of the tissues that take up no fluid: solid ones and air
    AcousticUniforms tissues[kMaxTissues];
};

struct LineUniforms {
    vec4 origin;     // patient frame, m; w: thickness of the gel in front of the skin, m
    vec4 direction;  // patient frame; w: two-way amplitude of the coupling; < 0: not marched
    vec4 needle;     // its echo: depth along the line, m; amplitude; shadow; drawn period of the rings, m
};

// x: for a sample. y, z, w: for a bin of the drawn depth.
struct DepthUniforms {
    // Sigma of the beam's thickness, m; amplitude of unit speckle; sigma of the beam's width, lines; gain.
    vec4 row;
};

#ifdef __cplusplus
}  // namespace stylet::render::gpu
#endif
#endif
