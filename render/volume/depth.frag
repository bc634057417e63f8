#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the depth for the runtime: that of the patient where the patient is nearly opaque, else that of the
// meshes.
#include "render/scene/bindings.glsl"

layout(location = 0) flat in int eye;

void main() {
    const ivec2 pixel = ivec2(gl_FragCoord.xy);
    const float opaque = texelFetch(mesh_depth, ivec3(pixel, eye), 0).r;
    const ivec2 tap = min(ivec2(gl_FragCoord.xy / frame.target.xy * frame.layer.xy), ivec2(frame.layer.xy) - 1);
    const float t = imageLoad(layer_depth, ivec3(tap, eye)).r;
    const float near = frame.target.z, far = frame.target.w;
    gl_FragDepth = t > 0.0 ? max(opaque, near * (far - t) / (t * (far - near))) : opaque;
}
