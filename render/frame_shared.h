// What the shaders read each frame. Included by C++ and by GLSL (std140): only vec4 and mat4, so both lay it
// out alike.
#ifndef STYLET_RENDER_FRAME_SHARED_H
#define STYLET_RENDER_FRAME_SHARED_H

#ifdef __cplusplus
#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

namespace stylet::render::gpu {
using glm::mat4;
using glm::vec4;
using uint = std::uint32_t;
#endif

// One eye. The ray through a pixel has the direction (tan_x, tan_y, -1) in the eye frame, so that a point's
// parameter along it IS its depth in metres.
struct EyeUniforms {
    mat4 clip_from_stage;
    mat4 stage_from_eye;
    mat4 patient_from_eye;
    vec4 tangents;  // left, right, up, down
};

// A change of the skin's colour, fixed to the tissue.
const int kMostMarks = 24, kMostCuts = 4;
const float kIncision = 1.0, kPuncture = 2.0, kBlood = 3.0, kIodine = 4.0;
struct MarkUniforms {
    vec4 place;  // reference patient, m; w: radius, or half the length of an incision
    vec4 shape;  // unit: an incision's direction, blood's way down; w: its kind
};

struct FrameUniforms {
    EyeUniforms eyes[2];
    mat4 patient_from_stage;
    vec4 target;             // width, height in pixels; near, far in metres
    vec4 key_stage;          // direction to the key light, stage; w its strength
    vec4 key_patient;        // the same in the patient frame
    vec4 up_patient;         // the stage's up in the patient frame
    vec4 shadow_stage;       // blob on the floor: centre x, z; half-extents x, z (0 = none)
    vec4 shadow_axis_stage;  // its long axis (x, z)
    vec4 grid_origin;        // m; w: 1 when there is a patient
    vec4 grid_spacing;       // m; w: ray step in voxels of the smallest spacing
    vec4 grid_dims;          // voxels; w: extinction of a full stored opacity, 1/m
    vec4 brick_dims;         // bricks
    vec4 deform_scale;       // patient frame to texture coordinates of the deformation: scale, 1/m
    vec4 deform_offset;      // and offset
    vec4 layer;              // width, height of the volume layer in pixels; cuts, marks
    vec4 fovea;  // tangent of the angle from the optical axis beyond which 4 and 16 pixels share a ray;
                 // shortest step in pixels
    vec4 cuts[kMostCuts];  // patient frame: what lies beyond dot(xyz, p) = w is cut away
    MarkUniforms marks[kMostMarks];
    vec4 tool_scale;  // as deform_scale, of what a tool displaces; w: half a node, m
    vec4 tool_offset;
};

// The body's material in the current look.
struct LookUniforms {
    vec4 surface;  // wrap of the diffuse term, specular strength, specular power, rim
    vec4 tint;     // colour of the diffuse term where the light grazes; w: reach of the gradient in voxels
    vec4 detail;   // how mottled the skin is, how deep its pores
};

// Volume layer: a workgroup covers this many pixels along either axis.
const int kTile = 8;

// Kinds of mesh parts: what differs in how they are lit. A thin part must not vanish between pixels.
const int kPlain = 0, kTable = 1, kFloor = 2, kScreen = 3, kCloth = 4;
// And what of the lamp's light reaches it: none, light from far away, or the beam with its shadows, which
// ends where it is weaker than this share of its middle.
const int kUnlit = 0, kFromAfar = 1, kBeam = 2;
const float kBeamEdge = 0.02;
const float kThin = 2.0;

// One mesh part.
struct MeshPush {
    mat4 stage_from_model;
    vec4 colour;    // linear, times the vertex's own; w: emission
    vec4 material;  // x: 1 + which screen, y: 1 when it is the room's shell, z: first eye, w: kThin or 0
};

// Counters, only written by the pipelines that count.
struct Counters {
    uint samples, rays, skipped_bricks, terminated_rays;
    uint depth_bounded_rays, samples_high, unused0, unused1;
};

#ifdef __cplusplus
static_assert(sizeof(EyeUniforms) == 208 && offsetof(EyeUniforms, tangents) == 192);
static_assert(sizeof(FrameUniforms) == 2 * 208 + 64 + (16 + 4 + 2 * kMostMarks) * 16 &&
              offsetof(FrameUniforms, target) == 480);
static_assert(sizeof(LookUniforms) == 48);
static_assert(sizeof(MeshPush) == 96);
static_assert(sizeof(Counters) == 32);
}  // namespace stylet::render::gpu
#endif
#endif
