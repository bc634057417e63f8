#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/scene/stereo.glsl"
#include "render/scene/bindings.glsl"

layout(push_constant) uniform Push { MeshPush part; };
layout(location = 0) flat out int eye;

// A triangle over the whole target, on the far plane.
void main() {
    eye = eyeIndex(int(part.material.z));
    gl_Position = vec4(float(gl_VertexIndex & 1) * 4.0 - 1.0, float(gl_VertexIndex & 2) * 2.0 - 1.0, 0.0, 1.0);
    routeEye();
}
