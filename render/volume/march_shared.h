// Constants of the volume march, on the GPU (volume.comp) and on the processor (march.cpp). Included by C++
// and by GLSL.
#ifndef STYLET_RENDER_MARCH_SHARED_H
#define STYLET_RENDER_MARCH_SHARED_H

#include "render/scene/shader_types.h"

#ifdef __cplusplus
namespace stylet::render::gpu {
#endif

const int kTile = 8;  // pixels of the volume layer that a workgroup covers along either axis
const int kBrickVoxels = 8;
const float kBrick = float(kBrickVoxels);

const float kOpaque = 0.001;   // transmittance at which rays end: a quarter of an 8-bit step
const int kDone = 0x7fffffff;  // a position past every ray's end
const int kFine = 4;           // sub-steps per step where tissue is dense
const float kDense = 0.30;     // optical depth of a step above which sub-steps are used
const float kWeak = 0.06;      // least share of the pixel for which a sample is lit by its gradient
const float kCutSteps = 1.5;   // steps behind a cut plane that are lit as the cut's surface
// Interleaved gradient noise (Jimenez 2014): factor of the inner fraction, weights of x and y.
SHADER_CONSTANT vec3 kDither = vec3(52.9829189, 0.06711056, 0.00583715);

const float kSurface = 0.15;      // opacity gradient per voxel that is lit as a full surface
const float kWeakKey = 0.45;      // share of the lamp's light on a sample that is not lit by its gradient
const float kTurnedAway = -0.4;   // cosine to the eye below which a surface shows its other side
const float kGrazingLight = 0.6;  // diffuse light below which it is tinted
const float kLeastAlbedo = 0.02;  // for the ratio of a surface's albedo with and without its detail
const float kWetStrength = 0.45, kWetPower = 45.0;  // highlight of a wet surface

// Detail of the skin and its marks (marks.glsl). Sizes in metres.
SHADER_CONSTANT vec3 kWound = vec3(0.10, 0.004, 0.006), kFlesh = vec3(0.42, 0.05, 0.04);
SHADER_CONSTANT vec3 kFreshBlood = vec3(0.17, 0.003, 0.004), kStain = vec3(0.50, 0.21, 0.055);
SHADER_CONSTANT vec3 kFlush = vec3(1.06, 0.90, 0.86);  // skin with more blood in it
const float kMarkDepth_m = 0.006;
const float kFleshFrom_m = 0.0010, kFleshTo_m = 0.0026;  // distances from the incision's line: flesh fades
const float kWoundFrom_m = 0.0005, kWoundTo_m = 0.0011;  // the same for the wound
const float kBloodRun = 0.62;                            // distances below the hole shrink by this share
const float kBloodWaver_m = 0.007, kIodineWaver_m = 0.03, kIodineGrain_m = 0.012;
const float kMottleCoarse_m = 0.013, kMottleFine_m = 0.004, kPore_m = 0.0011;

#ifdef __cplusplus
}  // namespace stylet::render::gpu
#endif
#endif
