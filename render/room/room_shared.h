// What the shaders read about the room each frame. Included by C++ and by GLSL (std140): only vec4 and mat4.
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

// Meshes are lit in the room frame: y up from the floor, the table's middle at the origin, z to the patient's
// head.
struct RoomUniforms {
    mat4 room_from_stage;
    mat4 patient_from_room;
    mat4 shadow_from_stage;  // clip space of the lamp's shadow map, depth reversed
    mat4 shadow_from_room;
    vec4 eyes[2];        // where they are, m
    vec4 lamp;           // m; w: 1 when it hangs there, 0: the direction of light that comes from far away
    vec4 beam;           // direction of its axis; w: distance from lamp to field, m
    vec4 shell;          // what the light that comes from floor, walls and ceiling is multiplied by
    vec4 settings;       // x: 1 when the shadow map is drawn, z: size of a texel of it
    vec4 irradiance[9];  // see environment.h
    vec4 contacts[kMostContacts];  // what stands on the floor: centre x, z; half-extents x, z, m (< 0: none)
    vec4 screens[kScreens];  // share of a layer's width and height that is picture; z: 1 when there is one;
                             // w: 1 when it is beneath
};

#ifdef __cplusplus
static_assert(sizeof(RoomUniforms) == 4 * 64 + (6 + 9 + kMostContacts + kScreens) * 16);
}  // namespace stylet::render::gpu
#endif
#endif
