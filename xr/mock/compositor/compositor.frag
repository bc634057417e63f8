// Paints one layer for one eye. Intersects the ray through the pixel with the layer, filters the layer's
// image over the pixel's footprint, and blends the result over the layers painted before. composition.cpp
// fills the push constants.
#version 450
#extension GL_EXT_samplerless_texture_functions : require

layout(constant_id = 0) const int kLayerType = 0;
const int kProjection = 0, kQuad = 1, kCylinder = 2;
const uint kBlendAlpha = 1, kMultiplyAlpha = 2;

layout(set = 0, binding = 0) uniform texture2DArray image;
layout(push_constant) uniform Constants {
    vec4 layer_from_eye[3];  // rows: rotation, then the eye's position
    vec4 eye_tangents;       // left, right, up, down
    vec4 shape;
    ivec4 rect;
    ivec2 picture_size;
    int array_index;
    uint blending;
};
layout(location = 0) out vec4 colour;

// A footprint up to this size [texels] is treated as one texel.
const float kOneTexel = 1.01;
const float kMaxSamples = 8.0;  // per axis
// A sample closer to a texel's centre than this [texels] is not blended with the neighbours. Hardware
// filtering also has only 8 bits of precision within a texel.
const float kCentre = 1.0 / 512.0;

// Intersects the ray through a point of the image with the layer's surface. `at` is in sub-image
// coordinates: (0, 0) top left, (1, 1) bottom right. Returns false if there is no intersection.
bool intersect(vec2 pixel, out vec2 at) {
    const vec2 t = pixel / vec2(picture_size);
    const vec3 ray = vec3(mix(eye_tangents.x, eye_tangents.y, t.x), mix(eye_tangents.z, eye_tangents.w, t.y), -1.0);
    const vec3 d = vec3(dot(layer_from_eye[0].xyz, ray), dot(layer_from_eye[1].xyz, ray),
                        dot(layer_from_eye[2].xyz, ray));
    const vec3 origin = vec3(layer_from_eye[0].w, layer_from_eye[1].w, layer_from_eye[2].w);
    at = vec2(0.0);
    if (kLayerType == kProjection) {
        if (d.z >= 0.0) return false;
        at = (d.xy / -d.z - shape.xz) / (shape.yw - shape.xz);
        return true;
    }
    if (kLayerType == kQuad) {
        if (origin.z <= 0.0 || d.z >= 0.0) return false;  // the eye is behind the quad, or the ray points away
        const vec2 p = origin.xy - d.xy * (origin.z / d.z);
        at = vec2(0.5 + p.x / shape.x, 0.5 - p.y / shape.y);
        return true;
    }
    // Only the inside is visible: use the point where the ray leaves the cylinder.
    const float flat2 = dot(d.xz, d.xz);
    if (flat2 <= 0.0) return false;
    vec3 p = d / sqrt(flat2);  // infinite cylinder: as radius 1, seen from the axis
    if (shape.z > 0.0) {
        const float along = dot(origin.xz, d.xz);
        const float inside = along * along - flat2 * (dot(origin.xz, origin.xz) - shape.z * shape.z);
        if (inside < 0.0) return false;
        const float distance = (sqrt(inside) - along) / flat2;
        if (distance <= 0.0) return false;
        p = (origin + distance * d) / shape.z;
    }
    at = vec2(0.5 + atan(p.x, -p.z) / shape.x, 0.5 - p.y / shape.y);
    return true;
}

vec4 texel(ivec2 at) {
    vec4 c = texelFetch(image, ivec3(rect.xy + clamp(at, ivec2(0), rect.zw - 1), array_index), 0);
    if ((blending & kBlendAlpha) == 0) c.a = 1.0;
    if ((blending & kMultiplyAlpha) != 0) c.rgb *= c.a;
    return clamp(c, 0.0, 1.0);
}

vec4 bilinear(vec2 at) {
    const vec2 p = at * vec2(rect.zw) - 0.5;
    const ivec2 first = ivec2(floor(p));
    vec2 f = p - floor(p);
    f = mix(mix(f, vec2(0.0), lessThan(f, vec2(kCentre))), vec2(1.0), greaterThan(f, vec2(1.0 - kCentre)));
    return mix(mix(texel(first), texel(first + ivec2(1, 0)), f.x),
               mix(texel(first + ivec2(0, 1)), texel(first + ivec2(1, 1)), f.x), f.y);
}

void main() {
    vec2 at, right, below;
    if (!intersect(gl_FragCoord.xy, at) || !all(greaterThanEqual(at, vec2(0.0))) || !all(lessThanEqual(at, vec2(1.0))))
        discard;
    const bool has_footprint =
        intersect(gl_FragCoord.xy + vec2(1.0, 0.0), right) && intersect(gl_FragCoord.xy + vec2(0.0, 1.0), below);
    const vec2 dx = right - at, dy = below - at;
    const float texels = max(length(dx * vec2(rect.zw)), length(dy * vec2(rect.zw)));
    if (!has_footprint || texels <= kOneTexel) {
        colour = bilinear(at);
        return;
    }
    const float n = min(ceil(texels), kMaxSamples);
    const float spread = 1.0 - 1.0 / texels;  // each sample already covers one texel
    colour = vec4(0.0);
    for (float j = 0.5; j < n; ++j)
        for (float i = 0.5; i < n; ++i)
            colour += bilinear(at + spread * (dx * (i / n - 0.5) + dy * (j / n - 0.5)));
    colour /= n * n;
}
