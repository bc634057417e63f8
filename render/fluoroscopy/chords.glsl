// Chords of capsules and cylinders in closed form: shapes.h. A shape is convex, so a ray meets it on one
// interval. Distances are measured from the point of the ray nearest to the shape. Measured from the
// source, a metre away, a needle's radius would be lost in rounding.

// Ray parameters [x, y] inside a cylinder that begins at the origin, with unit axis `u` and length `h`. Empty
// if x > y.
vec2 throughCylinder(vec3 o, vec3 d, vec3 u, float h, float r) {
    const float du = dot(d, u), ou = dot(o, u);
    const vec3 across = d - du * u, off = o - ou * u;
    const float a = dot(across, across), b = dot(across, off), c = dot(off, off) - r * r;
    vec2 t = vec2(-1e9, 1e9);
    if (a < 1e-12) {
        if (c > 0.0) return vec2(1.0, -1.0);
    } else {
        // Uses the ray's nearest point to the axis. The discriminant b * b - a * c would lose precision by
        // cancellation.
        const vec3 nearest = off - (b / a) * across;
        const float d2 = r * r - dot(nearest, nearest);
        if (d2 <= 0.0) return vec2(1.0, -1.0);
        const float half_chord = sqrt(d2 / a);
        t = -b / a + vec2(-half_chord, half_chord);
    }
    if (abs(du) < 1e-9) return ou >= 0.0 && ou <= h ? t : vec2(1.0, -1.0);
    const float s0 = -ou / du, s1 = (h - ou) / du;
    return vec2(max(t.x, min(s0, s1)), min(t.y, max(s0, s1)));
}

vec2 throughBall(vec3 o, vec3 d, float r) {
    const float b = dot(o, d);
    const vec3 nearest = o - b * d;
    const float d2 = r * r - dot(nearest, nearest);
    if (d2 <= 0.0) return vec2(1.0, -1.0);
    const float half_chord = sqrt(d2);
    return vec2(-b - half_chord, -b + half_chord);
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
    vec2 before = vec2(1.0, -1.0);
    for (int i = 0; i < count; ++i) {
        const ShapeUniforms shape = frame.shapes[i];
        const vec3 axis = shape.end.xyz - shape.begin.xyz;
        const float h = length(axis), r = shape.begin.w, bore = shape.end.w;
        const vec3 u = h > 0.0 ? axis / h : vec3(0.0, 0.0, 1.0);
        const float shift = dot(0.5 * (shape.begin.xyz + shape.end.xyz) - source, direction);
        const vec3 o = source + shift * direction - shape.begin.xyz;
        vec2 t = throughCylinder(o, direction, u, h, r);
        if (shape.material.y != 0.0) {
            t = hull(t, throughBall(o, direction, r));
            t = hull(t, throughBall(o - h * u, direction, r));
        }
        t = t.x > t.y ? t : clamp(t + shift, 0.0, reach);
        float inside = intervalLength(t);
        if (bore > 0.0 && inside > 0.0) {
            const vec2 hollow = throughCylinder(o, direction, u, h, bore);
            if (hollow.x <= hollow.y) inside -= intervalLength(clamp(hollow + shift, 0.0, reach));
        }
        if (shape.material.z != 0.0 && t.x <= t.y && before.x <= before.y)
            inside -= intervalLength(vec2(max(t.x, before.x), min(t.y, before.y)));
        path += shape.material.x * max(inside, 0.0);
        before = t;
    }
    return path;
}
