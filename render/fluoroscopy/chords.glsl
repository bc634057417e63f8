// Chords of capsules and cylinders in closed form: shapes.h. A shape is convex, so a ray meets it on one
// interval. Distances are measured from the point of the ray nearest to the shape. Measured from the
// source, a metre away, a needle's radius would be lost in rounding.
//
// A needle is about as thin as a pixel. One ray per pixel would miss most of it, so a thin shape is averaged
// over the pixel's footprint across its axis. The sum over the pixels across a shaft is then its attenuation
// times its cross-section, wherever it lies and however it is turned. A shaft below kNarrowest is widened to
// it, with the same attenuation times cross-section. Otherwise it would be dark where its axis meets the
// middle of a pixel, and pale where it runs between two.

// Shapes with a smaller radius are averaged; radius of the narrowest shaft; in half extents of the footprint.
const float kThin = 4.0, kNarrowest = 2.3;
const float kParallel = 1e-8;  // squared sine of the angle below which a ray is parallel to an axis
const vec2 kNoInterval = vec2(1.0, -1.0);

// How a pixel's rays pass the axis of a shape.
struct Passing {
    bool parallel;
    float sine2;  // squared sine of the angle between ray and axis
    float at;     // parameter of the middle ray's point nearest to the axis
    float off;    // its distance from the axis; if parallel, 0 stands for any distance within the shape
    // Across the axis the square footprint is a box smoothed by a second box: their half extents, m.
    vec2 pixel;
};

// Ray parameters inside a shape, and the share of the footprint that it covers.
struct Chord {
    vec2 t;  // empty if x > y
    float share;
};

// Area of a disc between the lines through its centre and at the distance `x`, halved. Odd in `x`.
float discArea(float x, float r) {
    const float s = clamp(x / r, -1.0, 1.0);
    return 0.5 * r * r * (s * sqrt(max(1.0 - s * s, 0.0)) + asin(s));
}

// Means over the footprint: the share of it within a strip of half width `r` (x), and half the chord of a
// disc of that radius (y). The second box is two boxes at the nodes of a Gauss rule.
vec2 averageDisc(Passing p, float r) {
    vec2 mean = vec2(0.0);
    for (int side = -1; side <= 1; side += 2) {
        const float middle = p.off + float(side) * 0.57735027 * p.pixel.y;
        const float low = clamp(middle - p.pixel.x, -r, r), high = clamp(middle + p.pixel.x, -r, r);
        if (low < high) mean += vec2(high - low, discArea(high, r) - discArea(low, r));
    }
    return mean / (4.0 * p.pixel.x);
}

bool isThin(Passing p, float r) { return !p.parallel && r < kThin * (p.pixel.x + p.pixel.y); }

// The factor by which a shaft is widened.
float widening(Passing p, float r) { return max(kNarrowest * p.pixel.x / r, 1.0); }

// `o`: the point of the ray at parameter 0, from the shape's begin. `u`: the shape's unit axis. `pixel_scale`:
// size of the footprint at parameter 0 relative to the detector, and its growth.
Passing passAxis(vec3 o, vec3 d, vec3 u, vec2 pixel_scale) {
    const vec3 across = d - dot(d, u) * u, off = o - dot(o, u) * u;
    const float sine2 = dot(across, across);
    if (sine2 < kParallel) return Passing(true, sine2, 0.0, length(off), vec2(0.0));
    const float at = -dot(across, off) / sine2;
    const vec3 n = cross(u, across) * inversesqrt(sine2);
    const float scale = pixel_scale.x + at * pixel_scale.y;
    const vec2 half_extents = 0.5 * scale * abs(vec2(dot(frame.right.xyz, n), dot(frame.down.xyz, n)));
    return Passing(false, sine2, at, abs(dot(off, n)),
                   vec2(max(half_extents.x, half_extents.y), min(half_extents.x, half_extents.y)));
}

// A cylinder from the origin along `u`, of length `h`.
Chord throughCylinder(Passing p, vec3 o, vec3 d, vec3 u, float h, float r) {
    Chord chord = Chord(vec2(-1e9, 1e9), 1.0);
    if (p.parallel) {
        if (p.off > r) return Chord(kNoInterval, 0.0);
    } else {
        float half_chord;
        if (isThin(p, r)) {
            const vec2 mean = averageDisc(p, r);
            if (mean.x <= 0.0) return Chord(kNoInterval, 0.0);
            chord.share = mean.x;
            half_chord = mean.y / mean.x;
        } else {
            if (p.off >= r) return Chord(kNoInterval, 0.0);
            half_chord = sqrt((r - p.off) * (r + p.off));
        }
        chord.t = p.at + vec2(-half_chord, half_chord) * inversesqrt(p.sine2);
    }
    const float du = dot(d, u), ou = dot(o, u);
    if (abs(du) < 1e-9) {
        if (ou < 0.0 || ou > h) chord.t = kNoInterval;
        return chord;
    }
    const float s0 = -ou / du, s1 = (h - ou) / du;
    chord.t = vec2(max(chord.t.x, min(s0, s1)), min(chord.t.y, max(s0, s1)));
    return chord;
}

// A ball at the origin, the round end of a shaft that covers `share` of the footprint. It is widened like the
// shaft, but not along it.
vec2 throughBall(Passing p, vec3 o, vec3 d, float r, float widen, float share) {
    const float b = dot(o, d);
    const vec3 nearest = o - b * d;
    const float off = p.parallel ? 0.0 : p.off;
    // Square of the radius of the ball's section at the ray's distance along the shaft.
    const float section2 = (r * r - max(dot(nearest, nearest) - off * off, 0.0)) * widen * widen;
    if (section2 <= 0.0 || share <= 0.0) return kNoInterval;
    float half_chord;
    if (isThin(p, r * widen)) {
        half_chord = averageDisc(p, sqrt(section2)).y / share;
    } else {
        if (section2 <= off * off) return kNoInterval;
        half_chord = sqrt(section2 - off * off);
    }
    return half_chord > 0.0 ? vec2(-b - half_chord, -b + half_chord) : kNoInterval;
}

vec2 hull(vec2 a, vec2 b) {
    if (a.x > a.y) return b;
    if (b.x > b.y) return a;
    return vec2(min(a.x, b.x), max(a.y, b.y));
}

float intervalLength(vec2 t) { return max(t.y - t.x, 0.0); }

float shapesPath(vec3 source, vec3 direction, float reach) {
    const int count = int(frame.iris.y);
    float path = 0.0;
    vec2 before = kNoInterval;
    for (int i = 0; i < count; ++i) {
        const ShapeUniforms shape = frame.shapes[i];
        const vec3 axis = shape.end.xyz - shape.begin.xyz;
        const float h = length(axis), r = shape.begin.w, bore = shape.end.w;
        const vec3 u = h > 0.0 ? axis / h : vec3(0.0, 0.0, 1.0);
        const float shift = dot(0.5 * (shape.begin.xyz + shape.end.xyz) - source, direction);
        const vec3 o = source + shift * direction - shape.begin.xyz;
        const Passing p = passAxis(o, direction, u, vec2(shift, 1.0) / reach);
        const float widen = widening(p, r);
        const Chord outer = throughCylinder(p, o, direction, u, h, r * widen);
        vec2 t = outer.t;
        if (shape.material.y != 0.0) {
            // A ray parallel to the axis has the same distance from both balls.
            const float share = p.parallel ? 1.0 : outer.share;
            t = hull(t, throughBall(p, o, direction, r, widen, share));
            t = hull(t, throughBall(p, o - h * u, direction, r, widen, share));
        }
        t = t.x > t.y ? t : clamp(t + shift, 0.0, reach);
        float inside = outer.share * intervalLength(t);
        if (bore > 0.0 && inside > 0.0) {
            const Chord hollow = throughCylinder(p, o, direction, u, h, bore * widen);
            if (hollow.t.x <= hollow.t.y)
                inside -= hollow.share * intervalLength(clamp(hollow.t + shift, 0.0, reach));
        }
        if (shape.material.z != 0.0 && t.x <= t.y && before.x <= before.y)
            inside -= outer.share * intervalLength(vec2(max(t.x, before.x), min(t.y, before.y)));
        path += shape.material.x / (widen * widen) * max(inside, 0.0);
        before = t;
    }
    return path;
}
