// What the passes of a scan read. Included by C++ and by GLSL (std140, std430): only vec4, uvec2 and mat4, so
// both lay it out alike.
#ifndef STYLET_RENDER_ULTRASOUND_SCAN_SHARED_H
#define STYLET_RENDER_ULTRASOUND_SCAN_SHARED_H

#ifdef __cplusplus
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

namespace stylet::render::gpu {
using glm::mat4;
using glm::vec4;
#endif

const int kMostTissues = 32, kMostPlanes = 17, kMostTaps = 6;
// A voxel (acoustic_volume.h) and a sample of the march, packed; offsets in bits.
const int kOtherAt = 5, kNearAt = 10, kNormalXAt = 16, kNormalYAt = 22, kVaryAt = 28;
const int kCrossingAt = 5, kFacingAt = 15;
const float kNearRange = 0.875;    // voxels
const float kCrossingRange = 2.0;  // steps, either way
// What makes both parts of a node's noise one of variance 1/2: two bytes have 2 (256^2 - 1) / 12.
const float kScattererScale = 0.0067658;
const float kComet = 0.30, kComet_m = 0.0035;             // a needle's ringing: of its echo, gone to 1/e
const float kUnknownFacing = 0.6;                         // of a change of impedance without a border
const float kFlowUnit = 32767.0, kFlowKindStep = 6000.0;  // patient/vessel_flow.h

struct AcousticUniforms {
    vec4 mean;  // ln impedance; amplitude that a step passes, there and back; what is drawn of it, m; scatter
    vec4
        vary;  // for a CT value that is one span higher: d ln impedance, ln of the scatter; wall amplitude, m
};

struct ScanUniforms {
    vec4 deform_scale, deform_offset;  // as in frame_shared.h
    vec4 tool_scale, tool_offset;
    vec4 voxel_scale;   // patient frame to voxels; w: roughness
    vec4 voxel_offset;  // w: which tissue is air
    vec4 voxel_dims;    // w: which is gel
    vec4 across;        // patient frame: the probe's +y; w: 1 / spacing of the scatterers, 1/m
    vec4 lattice[3];    // rows of the turn from the patient frame to the scatterers' lattice
    vec4
        march;  // step, m; bin as drawn, m; electronic noise, amplitude; amplified by so many neper a drawn m
    vec4 pulse[kMostTaps + 1];  // x: taps, from the middle; y: what makes a mirror's echo 1
    vec4 rings;                 // in air: period and decay, drawn m; amplitude
    vec4 tone;                  // dynamic range, dB; gain; number of the picture; 1: a guide is drawn
    vec4 planes[kMostPlanes];   // x: offset in standard deviations of the beam's thickness; y: weight
    vec4 probe;                 // convex 0, linear 1; radius; half-angle; half-width, m
    vec4 view;                  // picture: m a pixel; left, top in m; depth, m
    vec4 guide;                 // start and end in the picture's plane, m
    vec4 marks;                 // focus, m; spacing of the ticks, m; picture's width, height, pixels
    vec4 doppler;               // box: lines from, to (shares 0..1), depths from, to, m
    vec4 flow_scale;            // patient frame to voxels of the flow; w: m/s of its unit
    vec4 flow_offset;           // w: Nyquist's velocity, m/s
    vec4 flow_dims;             // voxels
    vec4 flow_look;             // wall filter, m/s; gain; columns and rows of the Doppler grid
    vec4 pulses[2];             // the heart's factor of each kind of vessel (patient/vessel_flow.h)
    vec4 reach;  // beam's width, standard deviations; the noise's correlation a step apart; creeping gel, m
    AcousticUniforms tissues[kMostTissues];
};

struct LineUniforms {
    vec4 origin;     // patient frame, m; w: thickness of the gel before the skin, m
    vec4 direction;  // patient frame; w: coupling, amplitude there and back; < 0: not marched
    vec4 needle;     // its echo: depth along the line, m; amplitude; shadow; drawn period of the rings, m
};

// Of a sample (x) and of a bin of the drawn depth (the rest).
struct DepthUniforms {
    vec4 row;  // sigma of the beam's thickness, m; amplitude of unit speckle; sigma of its width, lines; gain
};

#ifdef __cplusplus
}  // namespace stylet::render::gpu
#endif
#endif
