// Data that the shaders read each frame. Included by C++ and by GLSL (std140). Uses only vec4 and mat4, so
// that the layout is the same in both.
#ifndef STYLET_RENDER_FRAME_SHARED_H
#define STYLET_RENDER_FRAME_SHARED_H

#include "render/scene/shader_types.h"

#ifdef __cplusplus
namespace stylet::render::gpu {
#endif

// One eye. The ray through a pixel has the direction (tan_x, tan_y, -1) in the eye frame, so the ray
// parameter of a point is its depth in metres.
struct EyeUniforms {
    mat4 clip_from_stage;
    mat4 stage_from_eye;
    mat4 patient_from_eye;
    vec4 tangents;  // left, right, up, down
};

// A mark on the skin, fixed to the tissue.
const int kMaxMarks = 24, kMaxCuts = 4;
const float kIncision = 1.0, kPuncture = 2.0, kBlood = 3.0, kIodine = 4.0;
struct MarkUniforms {
    vec4 place;  // reference patient, m; w: radius, or half the length of an incision
    vec4 shape;  // unit vector: direction of an incision, or in which blood runs; w: kind
};

struct FrameUniforms {
    EyeUniforms eyes[2];
    mat4 patient_from_stage;
    vec4 target;             // width, height in pixels; near, far in metres
    vec4 key_stage;          // direction to the key light, stage frame; w: its strength
    vec4 key_patient;        // the same in the patient frame
    vec4 up_patient;         // up direction of the stage, in the patient frame
    vec4 shadow_stage;       // table's shadow on the floor: centre x, z; half-extents x, z (0: none)
    vec4 shadow_axis_stage;  // its long axis (x, z)
    vec4 grid_origin;        // m; w: 1 when there is a patient
    vec4 grid_spacing;       // m; w: ray step in voxels of the smallest spacing
    vec4 grid_dims;          // voxels; w: extinction at a stored opacity of 1, 1/m
    vec4 brick_dims;         // bricks
    vec4 deform_scale;       // patient frame to texture coordinates of the deformation: scale, 1/m
    vec4 deform_offset;      // and offset
    vec4 layer;              // width, height of the volume layer in pixels; number of cuts, of marks
    // Tangents of the angles from the optical axis: beyond x, 4 pixels share a ray, beyond y, 16. z: shortest
    // step in pixels.
    vec4 fovea;
    vec4 cuts[kMaxCuts];  // patient frame: tissue with dot(xyz, p) > w is cut away
    MarkUniforms marks[kMaxMarks];
    vec4 tool_scale;  // like deform_scale, for a tool's displacement; w: half a node spacing, m
    vec4 tool_offset;
};

// Material of the body in the current look.
struct LookUniforms {
    vec4 surface;  // wrap of the diffuse term, specular strength, specular power, rim
    vec4 tint;     // tint of the diffuse term in grazing light; w: reach of the gradient in voxels
    vec4 detail;   // strength of the skin's mottling, depth of its pores
};

// Light of the operating room, linear: the lamp, and the ambient light as a dome of two colours.
SHADER_CONSTANT vec3 kKeyColour = vec3(1.0, 0.965, 0.91);
SHADER_CONSTANT vec3 kSkyColour = vec3(0.36, 0.44, 0.47), kGroundColour = vec3(0.11, 0.12, 0.12);

const int kScreenPixels = 512;  // largest edge of the picture on a screen of the room

// Kinds of mesh parts; each is lit differently.
const int kPlain = 0, kTable = 1, kFloor = 2, kScreen = 3, kCloth = 4, kGhost = 5;
// Light of the lamp on a part: none, light from far away, or the beam with its shadows. The beam ends where
// it is weaker than kBeamEdge of its middle. kThin marks parts that must not vanish between pixels.
const int kUnlit = 0, kFromAfar = 1, kBeam = 2;
const float kBeamEdge = 0.02;
const float kThin = 2.0;

// One mesh part.
struct MeshPush {
    mat4 stage_from_model;
    vec4 colour;    // linear, multiplies the vertex colour; w: emission
    vec4 material;  // x: 1 + screen index, y: 1 for the room's shell, z: first eye, w: kThin or 0
};

// Counters. Only pipelines that count write them.
struct Counters {
    uint samples, rays, skipped_bricks, terminated_rays;
    uint depth_bounded_rays, samples_high, unused0, unused1;
};

#ifdef __cplusplus
static_assert(sizeof(EyeUniforms) == 208 && offsetof(EyeUniforms, tangents) == 192);
static_assert(sizeof(FrameUniforms) == 2 * 208 + 64 + (16 + 4 + 2 * kMaxMarks) * 16 &&
              offsetof(FrameUniforms, target) == 480);
static_assert(sizeof(LookUniforms) == 48);
static_assert(sizeof(MeshPush) == 96);
static_assert(sizeof(Counters) == 32);
}  // namespace stylet::render::gpu
#endif
#endif
