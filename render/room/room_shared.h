// Data about the room that the shaders read each frame. Included by C++ and by GLSL (std140): only vec4 and
// mat4.
#ifndef STYLET_RENDER_ROOM_ROOM_SHARED_H
#define STYLET_RENDER_ROOM_ROOM_SHARED_H

#include "render/scene/shader_types.h"

#ifdef __cplusplus
namespace stylet::render::gpu {
#endif

const int kMaxContacts = 10, kScreens = 3;

// The map of the room's light (environment.h): texels along an edge, levels of roughness from 0 to 1, largest
// radiance that it can store.
const int kMapSize = 64, kMapLevels = 6;
SHADER_CONSTANT float kMapRange = 2.56;
// Half of the room's extents (x, height, z) as in assets/generate/shell.py, and the point for which the map
// is computed. Room frame, m.
SHADER_CONSTANT vec3 kRoomHalf = vec3(3.4, 1.5, 3.1), kGatherPoint = vec3(0.0, 1.2, 0.0);

// Meshes are lit in the room frame: y up from the floor, the table's middle at the origin, z toward the
// patient's head.
struct RoomUniforms {
    mat4 room_from_stage;
    mat4 patient_from_room;
    mat4 shadow_from_stage;  // clip space of the lamp's shadow map, depth reversed
    mat4 shadow_from_room;
    vec4 eyes[2];                 // positions of the eyes, m
    vec4 lamp;                    // position, m, if w is 1; direction to a light far away if w is 0
    vec4 beam;                    // direction of its axis; w: distance from lamp to field, m
    vec4 shell;                   // factor of the light from floor, walls and ceiling
    vec4 settings;                // x: 1 if there is a shadow map, z: size of its texel
    vec4 irradiance[9];           // see environment.h
    vec4 contacts[kMaxContacts];  // footprints on the floor: centre x, z; half-extents x, z, m (< 0: none)
    // Share of the layer's width and height that the picture fills; z: 1 if there is one; w: 1 if a
    // composition layer beneath shows it.
    vec4 screens[kScreens];
};

#ifdef __cplusplus
static_assert(sizeof(RoomUniforms) == 4 * 64 + (6 + 9 + kMaxContacts + kScreens) * 16);
}  // namespace stylet::render::gpu
#endif
#endif
