#version 460
#extension GL_GOOGLE_include_directive : require
// Lays the volume layer over the opaque meshes. A layer with fewer pixels than the target is interpolated
// between layer pixels whose rays ended at a similar depth. Based on Kopf et al., "Joint bilateral
// upsampling", 2007.
#include "render/scene/bindings.glsl"
#include "render/scene/lighting.glsl"

layout(constant_id = 0) const uint kUpsample = 0;
layout(constant_id = 1) const uint kShadow = 0;

layout(location = 0) flat in int eye;
layout(location = 0) out vec4 colour;

const float kSameDepth = 0.02;  // relative difference of depth at which a pixel counts half
const float kLampShare = 0.62;  // lamp's share of the light on the patient's surface

// Factor of the colour where tools and equipment shade the patient's first surface from the lamp. Both kinds
// of march light the layer without these shadows, so the lamp's share is removed here.
float shadowOn(vec4 seen) {
    const ivec2 tap = min(ivec2(gl_FragCoord.xy / frame.target.xy * frame.layer.xy), ivec2(frame.layer.xy) - 1);
    const float t = imageLoad(layer_depth, ivec3(tap, eye)).r;
    if (t <= 0.0) return 1.0;
    const vec3 p = t * rayThrough(frame.eyes[eye].tangents, gl_FragCoord.xy / frame.target.xy);
    const float lit = lampShadow((frame.eyes[eye].stage_from_eye * vec4(p, 1.0)).xyz);
    return 1.0 - kLampShare * seen.a * (1.0 - lit);
}

void main() {
    const ivec2 pixel = ivec2(gl_FragCoord.xy);
    if (kUpsample == 0) {
        colour = imageLoad(layer_colour, ivec3(pixel, eye));
        if (kShadow != 0) colour.rgb *= shadowOn(colour);
        return;
    }
    const vec2 at = gl_FragCoord.xy / frame.target.xy * frame.layer.xy - 0.5;
    const ivec2 low = ivec2(floor(at)), end = ivec2(frame.layer.xy) - 1;
    const vec2 share = at - vec2(low);
    const float here = meshDepth(pixel, eye);
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 step = ivec2(i & 1, i >> 1), tap = clamp(low + step, ivec2(0), end);
        const vec2 place = (vec2(tap) + 0.5) / frame.layer.xy * frame.target.xy;
        const float apart = abs(meshDepth(min(ivec2(place), ivec2(frame.target.xy) - 1), eye) - here) / here / kSameDepth;
        const vec2 linear = mix(1.0 - share, share, vec2(step));
        const float weight = (linear.x * linear.y + 1e-4) / (1.0 + apart * apart);
        sum += weight * imageLoad(layer_colour, ivec3(tap, eye));
        weights += weight;
    }
    colour = sum / weights;
    if (kShadow != 0) colour.rgb *= shadowOn(colour);
}
