#version 460
#extension GL_GOOGLE_include_directive : require
// The part of an eye's picture that the lens hides. It is drawn on the near plane, so that nothing else is
// drawn there.
#include "render/scene/stereo.glsl"
#include "render/scene/bindings.glsl"

layout(push_constant) uniform Push { MeshPush part; };
layout(location = 0) in vec3 tangents_eye;  // tangents right and up; z: index of the eye

void main() {
    const int eye = eyeIndex(int(part.material.z));
    const vec4 range = frame.eyes[eye].tangents;
    const vec2 at = (tangents_eye.xy - range.xz) / (range.yw - range.xz) * 2.0 - 1.0;
    // The other eye's triangles are moved out of clip space.
    gl_Position = int(tangents_eye.z) == eye ? vec4(at, 1.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    routeEye();
}
