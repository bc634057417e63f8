// Detail of the skin from close by: mottling, pores, and the marks that the procedure leaves (Mark in
// scene.h). Include after march_shared.h.

struct Surface {
    vec3 albedo;
    float gloss;  // 0: as in the look, 1: wet
};

float hashed(ivec3 cell) {
    uint h = uint(cell.x) * 0x9e3779b1u + uint(cell.y) * 0x85ebca77u + uint(cell.z) * 0xc2b2ae3du;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return float((h ^ (h >> 15)) >> 8) / 16777216.0;
}

// Smooth noise between 0 and 1 with features of size 1.
float noise(vec3 p) {
    const vec3 low = floor(p), f = p - low, s = f * f * (3.0 - 2.0 * f);
    const ivec3 c = ivec3(low);
    const vec4 near = mix(vec4(hashed(c), hashed(c + ivec3(0, 1, 0)), hashed(c + ivec3(0, 0, 1)), hashed(c + ivec3(0, 1, 1))),
                          vec4(hashed(c + ivec3(1, 0, 0)), hashed(c + ivec3(1, 1, 0)), hashed(c + ivec3(1, 0, 1)),
                               hashed(c + ivec3(1, 1, 1))), s.x);
    return mix(mix(near.x, near.y, s.y), mix(near.z, near.w, s.y), s.z);
}

// Factor for a radius: the edge wavers by a fifth, over features of `size`. A perfect circle would look
// printed.
float wavering(vec3 p, float size) { return 1.0 + 0.4 * (noise(p / size) - 0.5); }

// Measures distances along the skin, because the drawn surface lies one or two millimetres above or below the
// marked surface.
void applyMark(inout Surface s, MarkUniforms mark, vec3 p, vec3 normal) {
    const vec3 off = p - mark.place.xyz, along = mark.shape.xyz;
    const float height = dot(off, normal);
    const vec3 d = off - normal * clamp(height, -kMarkDepth_m, kMarkDepth_m);
    const float size = mark.place.w, kind = mark.shape.w;
    if (dot(d, d) > 16.0 * size * size + 1e-4) return;
    if (kind == kIncision) {
        const float away = length(d - along * clamp(dot(d, along), -size, size));
        s.albedo = mix(s.albedo, kFlesh, 1.0 - smoothstep(kFleshFrom_m, kFleshTo_m, away));
        s.albedo = mix(s.albedo, kWound, 1.0 - smoothstep(kWoundFrom_m, kWoundTo_m, away));
    } else if (kind == kPuncture) {
        const float reach = length(d);
        // The hole's edge is blurred about its radius, the needle's.
        s.albedo = mix(s.albedo, kFlesh, 0.6 * (1.0 - smoothstep(size, 2.5 * size, reach)));
        s.albedo = mix(s.albedo, kWound, 1.0 - smoothstep(0.75 * size, 1.25 * size, reach));
    } else if (kind == kBlood) {
        // Blood runs down: the pool is longer below the hole than above it.
        const float below = dot(d, along);
        const float reach = length(d - along * max(below, 0.0) * kBloodRun) * wavering(p, kBloodWaver_m);
        const float wet = 1.0 - smoothstep(0.82 * size, 0.96 * size, reach);
        s.albedo = mix(s.albedo, kFreshBlood * (0.75 + 0.5 * smoothstep(0.4 * size, 0.95 * size, reach)), wet);
        s.gloss = max(s.gloss, wet);
    } else {
        const float stained = 1.0 - smoothstep(0.90 * size, size, length(d) * wavering(p, kIodineWaver_m));
        const vec3 brown = s.albedo * kStain * 1.15 + 0.05 * kStain;
        s.albedo = mix(s.albedo, brown, (0.70 + 0.25 * noise(p / kIodineGrain_m)) * stained);
    }
}

// The surface at a point of the reference patient, in metres.
Surface surfaceAt(vec3 p, vec3 normal, vec3 albedo, bool with_marks) {
    Surface s = Surface(albedo, 0.0);
    if (look.detail.x > 0.0) {
        const float flush = 0.65 * noise(p / kMottleCoarse_m) + 0.35 * noise(p / kMottleFine_m);
        s.albedo *= mix(vec3(1.0), kFlush, look.detail.x * (2.0 * flush - 1.0));
        s.albedo *= 1.0 - look.detail.y * smoothstep(0.55, 0.95, noise(p / kPore_m));
    }
    if (with_marks)
        for (int i = 0; i < int(frame.layer.w); ++i)
            applyMark(s, frame.marks[i], p, normal);
    return s;
}
