// Properties of a sample of a line, and of the step to the next one. Include after bindings.glsl.

struct Sample {
    uint tissue;
    float fluid;      // share of injected fluid
    float impedance;  // ln
    float scatter;    // amplitude
    float crossing;   // steps to the border of its voxel, along the line; kCrossingRange: none
    float facing;     // |cos| between that border's normal and the line; < 0: unknown
    float passes;     // two-way amplitude that passes a step in this tissue, with the machine's compensation
    float drawn;      // length that the machine draws for a step in this tissue, m
    vec2 noise;       // of the scatterers, unit variance
};

// The step from a sample to the next.
struct Step {
    float share;      // share of the step before the change
    float drawn;      // m
    float passes;     // amplitude that passes the whole step
    float jump;       // half of the difference of ln impedance
    float mirrored;   // reflected amplitude: tanh(jump), less at oblique incidence
};

vec4 soakedMean(uint tissue, float fluid) {
    return mix(frame.tissues[tissue].mean, frame.tissues[uint(frame.voxel_dims.w)].mean, fluid);
}

Sample makeSample(uint tissue, float variation, bool wall, float fluid, float crossing, float facing, vec2 noise) {
    const vec4 mean = soakedMean(tissue, fluid), by_hu = frame.tissues[tissue].variation;
    const float scatter = wall ? by_hu.z : frame.tissues[tissue].mean.w * exp(by_hu.y * variation);
    return Sample(tissue, fluid, mean.x + (1.0 - fluid) * by_hu.x * variation, (1.0 - fluid) * scatter, crossing, facing,
                  mean.y, mean.z, noise);
}

// Share of injected fluid. Tissue soaks it up: it has no sharp border, and it is no ball.
float fluidAt(vec3 p, uint tissue) {
    float share = 0.0;
    if ((frame.dry.x >> tissue & 1u) != 0u) return share;
    for (int d = 0; d < int(frame.reach.w); ++d) {
        const float away = length(p - frame.depots[d].xyz) / frame.depots[d].w;
        if (away * (1.0 - kLobeHeight) >= kFluidTo) continue;
        const vec3 q = p * kLobesPer_m;
        const float lobes = (sin(q.x + 1.7 * q.y) + sin(1.3 * q.y - q.z) + sin(1.6 * q.z - 0.7 * q.x)) / 3.0;
        share = max(share, 1.0 - smoothstep(kFluidFrom, kFluidTo, away * (1.0 + kLobeHeight * lobes)));
    }
    return kMostFluid * share;
}

// A border lies within a single step, because its voxel stores it as a plane. The pulse therefore sums up the
// whole jump.
Step stepBetween(Sample a, Sample b) {
    Step s;
    const bool ahead = a.crossing >= 0.0 && a.crossing <= 1.0, behind = b.crossing <= 0.0 && b.crossing >= -1.0;
    const bool changes = a.tissue != b.tissue;
    s.share = !changes ? 0.5 : ahead ? a.crossing : behind ? 1.0 + b.crossing : 0.5;
    const float facing = ahead ? a.facing : b.facing;
    s.drawn = mix(b.drawn, a.drawn, s.share);
    s.jump = 0.5 * (b.impedance - a.impedance);
    const float mirror = 1.0 - 2.0 / (exp(2.0 * s.jump) + 1.0);
    s.mirrored = mirror * (changes && facing >= 0.0 ? facing : kUnknownFacing);
    s.passes = mix(b.passes, a.passes, s.share) * (1.0 - mirror * mirror);
    return s;
}

// Decodes the octahedral encoding of a normal (Zeigler et al.).
vec3 unfold(uint x, uint y) {
    const vec2 e = vec2(x, y) * (2.0 / 63.0) - 1.0;
    vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
    const float under = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -under : under;
    n.y += n.y >= 0.0 ? -under : under;
    return normalize(n);
}

// Noise of a node of the scatterers' lattice: four bytes, two each for the real and the imaginary part.
vec2 scattererAt(uvec3 node) {
    uint h = node.x * 0x9e3779b1u ^ node.y * 0x85ebca77u ^ node.z * 0xc2b2ae3du;
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    h ^= h >> 15;
    return vec2(float(h & 255u) + float(h >> 8 & 255u), float(h >> 16 & 255u) + float(h >> 24)) - 255.0;
}

// Complex noise that is fixed to the tissue. It is interpolated linearly in the lattice's tetrahedra, and
// scaled to the same variance between nodes as on them.
vec2 scatterersAt(vec3 p) {
    const vec3 at = vec3(dot(frame.lattice[0].xyz, p), dot(frame.lattice[1].xyz, p), dot(frame.lattice[2].xyz, p)) *
                    frame.across.w;
    const vec3 low = floor(at), f = at - low;
    const uvec3 node = uvec3(ivec3(low));
    const float most = max(f.x, max(f.y, f.z)), least = min(f.x, min(f.y, f.z));
    const float middle = f.x + f.y + f.z - most - least;
    // Corners of the tetrahedron: from the lowest corner along the axis with the largest fraction, then along
    // the one with the next largest, then along the last.
    const uvec3 first = uvec3(f.x == most, f.x != most && f.y == most, f.x != most && f.y != most);
    const uvec3 last = uvec3(f.z != least && f.y != least, f.z != least && f.y == least, f.z == least);
    const vec4 w = vec4(1.0 - most, most - middle, middle - least, least);
    const vec2 sum = w.x * scattererAt(node) + w.y * scattererAt(node + first) +
                     w.z * scattererAt(node + 1u - last) + w.w * scattererAt(node + 1u);
    return sum * (kScattererScale * inversesqrt(dot(w, w)));
}

// `p`: position in the reference patient. `direction`: of the line. `depth_m`: depth along the line; up to
// `gel_m` there is gel.
Sample sampleAtPlace(vec3 p, vec3 direction, float depth_m, float gel_m) {
    const vec3 at = p * frame.voxel_scale.xyz + frame.voxel_offset.xyz;
    const ivec3 cell = ivec3(floor(at + 0.5));
    const bool inside = all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, ivec3(frame.voxel_dims.xyz)));
    const uint air = uint(frame.voxel_offset.w);
    uint code = texelFetch(voxels, clamp(cell, ivec3(0), ivec3(frame.voxel_dims.xyz) - 1), 0).x;
    code = inside ? code : air;
    uint tissue = code & 31u;
    const uint near = code >> kNearAt & 63u;
    float variation = (float(code >> kVariationAt) - 8.0) * (1.0 / 7.0), crossing = kCrossingRange, facing = -1.0, wall_m = 1.0;
    if (near != 0u) {
        const vec3 n = unfold(code >> kNormalXAt & 63u, code >> kNormalYAt & 63u);
        const float to_border = float(near) * (kNearRange / 63.0) - dot(n, at - vec3(cell));
        const vec3 normal = n * frame.voxel_scale.xyz;  // from voxels to metres
        const float along = dot(normal, direction), per_m = inversesqrt(dot(normal, normal));
        if (abs(along) * frame.march.x > 1e-5) crossing = to_border / (along * frame.march.x);
        facing = abs(along) * per_m;
        wall_m = abs(to_border) * per_m;
        if (to_border < 0.0) {
            tissue = code >> kOtherAt & 31u;
            variation = 0.0;
        }
    }
    float fluid = fluidAt(p, tissue);
    // Gel creeps into the gap that is left between a pressed face and the skin.
    const bool gel = depth_m < gel_m || (tissue == air && depth_m < gel_m + frame.reach.z);
    if (gel) {
        tissue = uint(frame.voxel_dims.w);
        variation = fluid = 0.0;
    }
    return makeSample(tissue, variation, !gel && wall_m < frame.tissues[tissue].variation.w, fluid, crossing, facing,
                      scatterersAt(p));
}

// Noise of a bin between two samples, with the same variance as theirs.
vec2 noiseBetween(vec2 a, vec2 b, float share) {
    const float other = 1.0 - share;
    return (other * a + share * b) * inversesqrt(other * other + share * share + 2.0 * other * share * frame.reach.y);
}

// Rings of a probe in air, which receives repeated echoes of its own face.
float rings(float t) {
    const float phase = 0.5 + 0.5 * cos(6.2831853 * t / frame.rings.x);
    return frame.rings.z * exp(-t / frame.rings.y) * phase * phase;
}

// Echo of the needle with its comet tail, and the shadow behind it. `at`: drawn depth of the needle, and
// the amplitude left there.
float needleEcho(vec4 needle, vec2 at, float t) {
    const float behind = t - at.x, bin = frame.march.y;
    const float glint = exp(-0.5 * behind * behind / (bin * bin));
    const float phase = 0.5 + 0.5 * cos(6.2831853 * behind / needle.w);
    const float comet = behind > 0.0 ? kComet * exp(-behind / kComet_m) * phase : 0.0;
    return needle.y * at.y * (glint + comet);
}
float needleShadow(vec4 needle, vec2 at, float t) {
    return 1.0 - needle.z * smoothstep(0.0, 0.002, t - at.x);
}
