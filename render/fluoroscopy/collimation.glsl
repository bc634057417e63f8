// Share of a pixel that the blades and the iris leave open: openShare() in beam.h. `at`: position right and
// down of the detector's middle.
float openShare(vec4 blades, float iris, vec2 at, float pixel) {
    float inside = min(min(at.x + blades.x, blades.y - at.x), min(at.y + blades.z, blades.w - at.y));
    if (iris > 0.0) inside = min(inside, iris - length(at));
    return clamp(inside / pixel + 0.5, 0.0, 1.0);
}
