#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the shadow casters as seen from the lamp.
#include "render/scene/bindings.glsl"

layout(push_constant) uniform Push { MeshPush part; };
layout(location = 0) in vec3 position;

void main() { gl_Position = room.shadow_from_stage * (part.stage_from_model * vec4(position, 1.0)); }
