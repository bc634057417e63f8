#version 460
#extension GL_GOOGLE_include_directive : require

// Scan conversion at an assumed 1540 m/s, and the machine's overlays.
layout(local_size_x = 8, local_size_y = 8) in;
#include "render/ultrasound/bindings.glsl"

const float kGuideAside_m = 0.003;  // distance of each dashed line from the guide's line

// Line (share of all, 0 to 1) and depth (m) of a point of the picture's plane.
vec2 scanFrom(vec2 p) {
    if (frame.probe.x > 0.5) return vec2(p.x / frame.probe.w * 0.5 + 0.5, p.y);
    const vec2 from_centre = p + vec2(0.0, frame.probe.y);
    return vec2(atan(from_centre.x, from_centre.y) / frame.probe.z * 0.5 + 0.5, length(from_centre) - frame.probe.y);
}

float greyAt(vec2 scan) {
    const float l = scan.x * float(kLines - 1), t = scan.y / frame.march.y;
    const int line = clamp(int(l), 0, kLines - 2), bin = clamp(int(t), 0, kSamples - 2);
    const int at = line * kSamples + bin;
    const vec2 f = clamp(vec2(l - float(line), t - float(bin)), 0.0, 1.0);
    return mix(mix(grey[at], grey[at + 1], f.y), mix(grey[at + kSamples], grey[at + kSamples + 1], f.y), f.x);
}

// Red toward the probe, blue away from it, lighter when faster.
vec3 flowColour(float v) {
    const float fast = abs(v);
    const vec3 slow = v > 0.0 ? vec3(0.45, 0.02, 0.02) : vec3(0.03, 0.05, 0.50);
    const vec3 quick = v > 0.0 ? vec3(1.0, 0.85, 0.25) : vec3(0.45, 0.95, 1.0);
    return mix(slow, quick, fast);
}

vec3 withDoppler(vec3 colour, vec2 scan) {
    const vec4 box = frame.doppler;
    if (scan.x < box.x || scan.x > box.y || scan.y < box.z || scan.y > box.w) return colour;
    const int columns = int(frame.flow_look.z), rows = int(frame.flow_look.w);
    const vec2 at = vec2((scan.x - box.x) / (box.y - box.x) * float(columns - 1),
                         (scan.y - box.z) / (box.w - box.z) * float(rows - 1));
    const ivec2 cell = clamp(ivec2(at), ivec2(0), ivec2(columns, rows) - 2);
    const vec2 f = clamp(at - vec2(cell), 0.0, 1.0);
    const int i = cell.x * rows + cell.y;
    const vec2 a = doppler[i], b = doppler[i + 1], c = doppler[i + rows], d = doppler[i + rows + 1];
    // Colours must not blend across the jump of an aliased velocity. Only corners with a velocity near that
    // of the strongest one are blended.
    const vec4 weights = vec4((1.0 - f.x) * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * (1.0 - f.y), f.x * f.y);
    const vec4 shown = vec4(a.y, b.y, c.y, d.y) * weights;
    const float strength = shown.x + shown.y + shown.z + shown.w;
    if (strength < 0.35) return colour;
    const vec4 v = vec4(a.x, b.x, c.x, d.x);
    const float most = max(max(shown.x, shown.y), max(shown.z, shown.w));
    const float lead = shown.x == most ? v.x : shown.y == most ? v.y : shown.z == most ? v.z : v.w;
    const vec4 like = mix(vec4(0.0), shown, lessThan(abs(v - lead), vec4(0.5)));
    return flowColour(dot(like, v) / max(like.x + like.y + like.z + like.w, 1e-6));
}

// Half of the width of the lines of box and ruler, m. A thinner line would break up on its way over the pixels.
float halfLine() { return 0.6 * frame.view.x; }

// Share of a pixel that a line of this half-width covers.
float covered(float distance_m, float half_m) {
    return clamp(0.5 + (half_m - distance_m) / frame.view.x, 0.0, 1.0);
}

// Two dashed lines beside the guide's line, so that they do not hide the needle in it.
vec3 withGuide(vec3 colour, vec2 p) {
    const vec2 from = frame.guide.xy, along = frame.guide.zw - from;
    const float length_m = length(along);
    if (length_m < 1e-6) return colour;
    const vec2 unit = along / length_m;
    const float at = dot(p - from, unit);
    if (at < 0.0 || at > length_m || fract(at / 0.008) > 0.5) return colour;
    const float aside = abs(dot(p - from, vec2(-unit.y, unit.x)));
    return mix(colour, vec3(0.95, 0.85, 0.25), covered(abs(aside - kGuideAside_m), halfLine()));
}

vec3 withBox(vec3 colour, vec2 scan) {
    const vec4 box = frame.doppler;
    const float line_m = scan.y + (frame.probe.x > 0.5 ? 0.0 : frame.probe.y);
    const float width = frame.probe.x > 0.5 ? 2.0 * frame.probe.w : 2.0 * frame.probe.z * line_m;
    const vec2 outside_x = vec2(box.x - scan.x, scan.x - box.y) * width, outside_y = vec2(box.z - scan.y, scan.y - box.w);
    const float out_x = max(outside_x.x, outside_x.y), out_y = max(outside_y.x, outside_y.y);
    return mix(colour, vec3(0.85, 0.9, 0.6), 0.7 * covered(abs(max(out_x, out_y)), halfLine()));
}

// Draws centimetres down the side and a wedge at the focus.
vec3 withRuler(vec3 colour, vec2 pixel, float depth_m) {
    const float from_edge = frame.marks.z - 1.0 - pixel.x;
    if (from_edge > 14.0 || depth_m < -0.0005 || depth_m > frame.view.w + 0.0005) return colour;
    const float spacing = frame.marks.y, to_tick = abs(depth_m - round(depth_m / spacing) * spacing);
    const bool fifth = mod(round(depth_m / spacing) + 0.5, 5.0) < 1.0;
    if (from_edge >= 2.0 && from_edge < (fifth ? 9.0 : 6.0)) colour = max(colour, vec3(0.7) * covered(to_tick, halfLine()));
    const float down = abs(depth_m - frame.marks.x) / frame.view.x;
    return from_edge >= 9.0 && down < (from_edge - 9.0) ? vec3(0.9, 0.8, 0.2) : colour;
}

void main() {
    const ivec2 size = ivec2(frame.marks.zw), pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, size))) return;
    const vec2 p = frame.view.yz + (vec2(pixel) + 0.5) * frame.view.x;
    vec3 colour = vec3(0.0);
    const vec2 scan = scanFrom(p);
    const bool inside = scan.x >= 0.0 && scan.x <= 1.0 && scan.y >= 0.0 && scan.y <= frame.view.w;
    // A loop instead of a branch: software rasterisers skip a loop that no lane enters, but execute both
    // sides of a branch.
    for (int once = 0; once < int(inside); ++once) {
        colour = vec3(greyAt(scan));
        if (kColour) colour = withBox(withDoppler(colour, scan), scan);
        if (frame.tone.w > 0.5) colour = withGuide(colour, p);
    }
    colour = withRuler(colour, vec2(pixel), p.y);
    picture[pixel.y * size.x + pixel.x] = packUnorm4x8(vec4(colour, 1.0));
}
