// Data about the room that the shaders read each frame. Included by C++ and by GLSL (std140): only vec4 and
// mat4.
#ifndef STYLET_RENDER_ROOM_ROOM_SHARED_H
#define STYLET_RENDER_ROOM_ROOM_SHARED_H

#ifdef __cplusplus
#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

namespace stylet::render::gpu {
using glm::mat4;
using glm::vec4;
#endif

const int kMostContacts = 10, kScreens = 3;

// Meshes are lit in the room frame: y up from the floor, the table's middle at the origin, z toward the
// patient's head.
struct RoomUniforms {
    mat4 room_from_stage;
    mat4 patient_from_room;
    mat4 shadow_from_stage;  // clip space of the lamp's shadow map, depth reversed
    mat4 shadow_from_room;
    vec4 eyes[2];                  // positions of the eyes, m
    vec4 lamp;                     // position, m, if w is 1; direction to a light far away if w is 0
    vec4 beam;                     // direction of its axis; w: distance from lamp to field, m
    vec4 shell;                    // factor of the light from floor, walls and ceiling
    vec4 settings;                 // x: 1 if there is a shadow map, z: size of its texel
    vec4 irradiance[9];            // see environment.h
    vec4 contacts[kMostContacts];  // footprints on the floor: centre x, z; half-extents x, z, m (< 0: none)
    // Share of the layer's width and height that the picture fills; z: 1 if there is one; w: 1 if it is
    // shown beneath.
    vec4 screens[kScreens];
};

#ifdef __cplusplus
static_assert(sizeof(RoomUniforms) == 4 * 64 + (6 + 9 + kMostContacts + kScreens) * 16);
}  // namespace stylet::render::gpu
#endif
#endif
