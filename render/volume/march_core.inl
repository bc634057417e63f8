// The march itself. Included by march.cpp once for each instruction set, in a namespace that defines
// MARCH_FN, lower, higher, fetchTexel, fetchOpacity, fetchNode and storeHalf. Names and order follow
// volume.comp.

struct Ray {
    Float4 origin, direction, inverse;  // voxels of the deformed patient's grid; per unit of t
    Float4 to_eye;
    float t_begin, t_exit, t_mesh;
    float metres;  // per unit of t
    float step_m;
    float start;  // share of a step before the first sample
    int face;     // index of the cut plane through which it enters, or -1
};

struct Surface {
    Float4 albedo;
    float gloss;  // 0: as in the look, 1: wet
};

MARCH_FN float sum3(Float4 v) {
    return v[0] + v[1] + v[2];
}
MARCH_FN float dot3(Float4 a, Float4 b) {
    return sum3(a * b);
}
MARCH_FN Float4 all(float x) {
    return Float4{x, x, x, x};
}
MARCH_FN float lowest3(Float4 v) {
    return std::min(v[0], std::min(v[1], v[2]));
}
MARCH_FN float highest3(Float4 v) {
    return std::max(v[0], std::max(v[1], v[2]));
}
MARCH_FN Float4 normalised(Float4 v) {
    return v * (1.0f / std::sqrt(dot3(v, v)));
}
MARCH_FN Float4 mixed(Float4 a, Float4 b, float share) {
    return a + (b - a) * share;
}
MARCH_FN float fraction(float x) {
    return x - std::floor(x);
}
MARCH_FN float smoothstep(float a, float b, float x) {
    const float s = std::clamp((x - a) / (b - a), 0.0f, 1.0f);
    return s * s * (3.0f - 2.0f * s);
}

// exp(-x) for x >= 0, relative error 3e-7. Computes 2^f by its series about -1/2.
MARCH_FN float expNegative(float x) {
    const float y = std::max(x * -1.44269504f, -126.0f);
    const int whole = int(y);
    const float f = (y - float(whole) + 0.5f) * 0.69314718f, f2 = f * f;
    const float p = (1.0f + f) + f2 * ((0.5f + f * 0.16666667f) +
                                       f2 * ((0.041666667f + f * 8.3333333e-3f) + f2 * 1.38889e-3f));
    return p * 0.70710678f * std::bit_cast<float>((whole + 127) << 23);
}

// x^power of a highlight for 0 <= x <= 1, to 1e-4. Computes the logarithm by its series in (m - 1) / (m +
// 1).
MARCH_FN float highlight(float x, float power) {
    if (x < 1e-6f) return 0.0f;
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const std::uint32_t shifted = bits - 0x3f3504f3u;  // bits of sqrt(1/2)
    const int exponent = int(shifted) >> 23;
    const float m = std::bit_cast<float>(bits - (std::uint32_t(exponent) << 23));
    const float s = (m - 1.0f) / (m + 1.0f), s2 = s * s;
    const float log = 0.69314718f * float(exponent) + 2.0f * s * (1.0f + s2 * (0.33333333f + s2 * 0.2f));
    return expNegative(std::max(-power * log, 0.0f));
}

// First of the eight texels around a point. `share`: position of the point between them, 0 to 1.
MARCH_FN const std::uint32_t* cellAt(const Shared& s, Float4 voxel, Float4& share) {
    const Float4 at = lower(higher(voxel + 1.0f, all(0.0f)), s.last_cell);
    const Int4 low = __builtin_convertvector(at, Int4);
    share = at - __builtin_convertvector(low, Float4);
    return s.texels + (std::size_t(std::uint32_t(low[2])) * s.plane +
                       std::size_t(std::uint32_t(low[1])) * s.row + std::size_t(std::uint32_t(low[0])));
}

MARCH_FN Float4 texelAt(const Shared& s, Float4 voxel) {
    Float4 share;
    const std::uint32_t* p = cellAt(s, voxel, share);
    return fetchTexel(p, s.row, s.plane, share);
}

MARCH_FN float opacityAt(const Shared& s, Float4 voxel) {
    Float4 share;
    const std::uint32_t* p = cellAt(s, voxel, share);
    return fetchOpacity(p, s.row, s.plane, share);
}

// `at` is in nodes. Outside the grid the border's value.
MARCH_FN Float4 nodeAt(const NodeGrid& grid, const glm::vec4* table, Float4 at) {
    at = lower(higher(at, all(0.0f)), grid.last);
    Int4 low = __builtin_convertvector(at, Int4);
    low = low < grid.last_low ? low : grid.last_low;
    const Float4 f = at - __builtin_convertvector(low, Float4);
    const glm::vec4* node =
        table + (std::size_t(std::uint32_t(low[2])) * grid.plane +
                 std::size_t(std::uint32_t(low[1])) * grid.row + std::size_t(std::uint32_t(low[0])));
    return fetchNode(&node->x, 4 * grid.row, 4 * grid.plane, f);
}

// Displacement of the tissue at p by a tool, m. Zero outside the table's box.
MARCH_FN Float4 toolMoved(const Shared& s, Float4 p) {
    const Float4 at = p * s.tool.scale + s.tool.offset;
    const Float4 outside = higher(-0.5f - at, at - s.tool.last - 0.5f);
    if (highest3(outside) > 0.0f) return all(0.0f);
    return nodeAt(s.tool, s.moved, at);
}

// Transforms a gradient of the undisplaced tissue to the displaced tissue.
MARCH_FN Float4 turnedByTool(const Shared& s, Float4 p, Float4 g) {
    const Float4 here = toolMoved(s, p);
    if (here[0] == 0.0f && here[1] == 0.0f && here[2] == 0.0f) return g;
    const float h = s.tool_half_node;
    Float4 turned = g;
    for (int axis = 0; axis < 3; ++axis) {
        Float4 d = all(0.0f);
        d[axis] = h;
        turned[axis] -= dot3(toolMoved(s, p + d) - here, g) / h;
    }
    return turned;
}

// Reference position of a point of the deformed patient's grid, both in voxels.
MARCH_FN Float4 referenceVoxel(const Shared& s, Float4 voxel) {
    Float4 p = s.grid_origin + voxel * s.spacing, moved = all(0.0f);
    if (s.moved) {
        moved = -toolMoved(s, p);
        p += moved;
    }
    if (s.inside) {
        const Float4 at = p * s.breath.scale + s.breath.offset;
        Float4 breath = nodeAt(s.breath, s.inside, at);
        if (breath[3] >= 0.0f) breath = nodeAt(s.breath, s.outside, at);
        moved += breath;
    }
    return voxel + moved * s.per_spacing;
}

// Gradient of the opacity per voxel edge of the finest spacing. A stored opacity of 255 is 1.
MARCH_FN Float4 gradientAt(const Shared& s, Float4 v) {
    const float h = s.gradient_voxels;
    const Float4 x = {h, 0, 0, 0}, y = {0, h, 0, 0}, z = {0, 0, h, 0};
    const Float4 g = {opacityAt(s, v + x) - opacityAt(s, v - x), opacityAt(s, v + y) - opacityAt(s, v - y),
                      opacityAt(s, v + z) - opacityAt(s, v - z), 0.0f};
    return g * s.gradient_scale;
}

MARCH_FN Float4 ambientLight(const Shared& s, float up) {
    return s.ground + (s.sky - s.ground) * (0.5f + 0.5f * up);
}

MARCH_FN Float4 floored(Float4 v) {
    return Float4{std::floor(v[0]), std::floor(v[1]), std::floor(v[2]), 0.0f};
}

// From here to surfaceAt(): the same functions as in marks.glsl.
MARCH_FN float hashed(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    std::uint32_t h = x * 0x9e3779b1u + y * 0x85ebca77u + z * 0xc2b2ae3du;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return float((h ^ (h >> 15)) >> 8) / 16777216.0f;
}

MARCH_FN float noise(Float4 p) {
    const Float4 low = floored(p), f = p - low, s = f * f * (3.0f - 2.0f * f);
    const auto x = std::uint32_t(int(low[0])), y = std::uint32_t(int(low[1])), z = std::uint32_t(int(low[2]));
    const Float4 near = {hashed(x, y, z), hashed(x, y + 1, z), hashed(x, y, z + 1), hashed(x, y + 1, z + 1)};
    const Float4 far = {hashed(x + 1, y, z), hashed(x + 1, y + 1, z), hashed(x + 1, y, z + 1),
                        hashed(x + 1, y + 1, z + 1)};
    const Float4 n = mixed(near, far, s[0]);
    const float front = n[0] + (n[1] - n[0]) * s[1], back = n[2] + (n[3] - n[2]) * s[1];
    return front + (back - front) * s[2];
}

MARCH_FN float wavering(Float4 p, float size) {
    return 1.0f + 0.4f * (noise(p * (1.0f / size)) - 0.5f);
}

MARCH_FN float length3(Float4 v) {
    return std::sqrt(dot3(v, v));
}

MARCH_FN void applyMark(Surface& skin, const PlacedMark& mark, Float4 p, Float4 normal) {
    const Float4 off = p - mark.place, along = mark.along;
    const Float4 d = off - normal * std::clamp(dot3(off, normal), -kMarkDepth_m, kMarkDepth_m);
    const float size = mark.size;
    if (dot3(d, d) > 16.0f * size * size + 1e-4f) return;
    if (mark.kind == gpu::kIncision) {
        const float away = length3(d - along * std::clamp(dot3(d, along), -size, size));
        skin.albedo = mixed(skin.albedo, kFlesh, 1.0f - smoothstep(kFleshFrom_m, kFleshTo_m, away));
        skin.albedo = mixed(skin.albedo, kWound, 1.0f - smoothstep(kWoundFrom_m, kWoundTo_m, away));
    } else if (mark.kind == gpu::kPuncture) {
        const float reach = length3(d);
        skin.albedo = mixed(skin.albedo, kFlesh, 0.6f * (1.0f - smoothstep(size, 2.5f * size, reach)));
        skin.albedo =
            mixed(skin.albedo, kWound, 1.0f - smoothstep(0.75f * size, 1.25f * size, reach));
    } else if (mark.kind == gpu::kBlood) {
        const float below = dot3(d, along);
        const float reach = length3(d - along * (std::max(below, 0.0f) * kBloodRun)) * wavering(p, kBloodWaver_m);
        const float wet = 1.0f - smoothstep(0.82f * size, 0.96f * size, reach);
        const float thin = 0.75f + 0.5f * smoothstep(0.4f * size, 0.95f * size, reach);
        skin.albedo = mixed(skin.albedo, kFreshBlood * thin, wet);
        skin.gloss = std::max(skin.gloss, wet);
    } else {
        const float stained = 1.0f - smoothstep(0.90f * size, size, length3(d) * wavering(p, kIodineWaver_m));
        const Float4 brown = skin.albedo * kStain * 1.15f + 0.05f * kStain;
        skin.albedo = mixed(skin.albedo, brown, (0.70f + 0.25f * noise(p * (1.0f / kIodineGrain_m))) * stained);
    }
}

// The surface at a point of the reference patient, in metres.
MARCH_FN Surface surfaceAt(const Shared& s, Float4 p, Float4 normal, Float4 albedo) {
    Surface skin{albedo, 0.0f};
    if (s.mottle > 0.0f) {
        const float flush = 0.65f * noise(p * (1.0f / kMottleCoarse_m)) + 0.35f * noise(p * (1.0f / kMottleFine_m));
        skin.albedo *= mixed(all(1.0f), kFlush, s.mottle * (2.0f * flush - 1.0f));
        skin.albedo *= 1.0f - s.pores * smoothstep(0.55f, 0.95f, noise(p * (1.0f / kPore_m)));
    }
    for (int i = 0; i < s.marks; ++i)
        applyMark(skin, s.mark[std::size_t(i)], p, normal);
    return skin;
}

MARCH_FN Surface surfaceAtVoxel(const Shared& s, Float4 voxel, Float4 slope, Float4 albedo) {
    const Float4 normal = slope * (-1.0f / std::max(length3(slope), 1e-6f));
    return surfaceAt(s, s.grid_origin + voxel * s.spacing, normal, albedo);
}

// Detail of a surface as a factor of the albedo.
MARCH_FN Float4 surfaceTint(const Surface& skin, Float4 albedo) {
    return higher(skin.albedo, all(kLeastAlbedo)) / higher(albedo, all(kLeastAlbedo));
}

MARCH_FN Float4 shade(const Shared& s, const Surface& skin, Float4 g, Float4 to_eye) {
    const float steepness = std::sqrt(dot3(g, g));
    Float4 n = g * (-1.0f / std::max(steepness, 1e-6f));
    const float facing = dot3(n, to_eye);
    if (facing < 0.0f) n = facing < kTurnedAway ? -n : normalised(n - facing * to_eye);
    const float nl = dot3(n, s.key_direction);
    const float lit = std::max((nl + s.wrap) / (1.0f + s.wrap), 0.0f);
    const Float4 grazing = mixed(s.tint, all(1.0f), smoothstep(0.0f, kGrazingLight, lit));
    const float surface = smoothstep(0.0f, kSurface, steepness);
    const Float4 half = normalised(s.key_direction + to_eye);
    const float strength = s.specular + (kWetStrength - s.specular) * skin.gloss;
    const float power = s.specular_power + (kWetPower - s.specular_power) * skin.gloss;
    const float shine = nl > 0.0f ? strength * highlight(dot3(n, half), power) * nl : 0.0f;
    const float across = 1.0f - std::max(dot3(n, to_eye), 0.0f);
    const float rim = s.rim * across * across * across;
    const Float4 full =
        skin.albedo * (ambientLight(s, dot3(n, s.up)) + s.key * lit * grazing) + s.key * shine + s.sky * rim;
    return mixed(skin.albedo * s.weak_light, full, surface);
}

// Ray parameter at which the ray leaves the cube of known-empty bricks around `brick`.
MARCH_FN float leaveEmpty(const Ray& r, Float4 brick, float radius) {
    const Float4 low = (brick - (radius - 1.0f)) * kBrick - 0.5f, high = (brick + radius) * kBrick - 0.5f;
    return lowest3(higher((low - r.origin) * r.inverse, (high - r.origin) * r.inverse));
}

MARCH_FN void applyCuts(const Shared& s, const EyeRays& eye, Float4 direction, Ray& r) {
    for (int i = 0; i < s.cuts; ++i) {
        const Float4 cut = s.cut[std::size_t(i)];
        const float height = dot3(cut, eye.place) - cut[3], slope = dot3(cut, direction);
        const float t = -height / (std::fabs(slope) < 1e-9f ? 1e-9f : slope);
        if (slope >= 0.0f)
            r.t_exit = std::min(r.t_exit, height > 0.0f && slope < 1e-9f ? -1.0f : t);
        else if (t > r.t_begin)
            r.t_begin = t, r.face = i;
    }
}

// `at_x`, `at_y`: position of the ray as shares of the layer. `size`: pixels along an axis that share the
// ray. Returns false if the ray misses the volume.
MARCH_FN bool makeRay(const Shared& s, const EyeRays& eye, float at_x, float at_y, std::uint32_t size,
                      Ray& r) {
    const Float4 direction = eye.corner + eye.across * at_x + eye.down * at_y;
    r.metres = std::sqrt(dot3(direction, direction));
    r.to_eye = direction * (-1.0f / r.metres);
    r.origin = eye.origin;
    r.direction = direction * s.per_spacing;
    const Float4 length = higher(r.direction, -r.direction);
    r.inverse = 1.0f / (length < 1e-9f ? all(1e-9f) : r.direction);
    const Float4 ta = (all(-0.5f) - r.origin) * r.inverse, tb = (s.dims - 0.5f - r.origin) * r.inverse;
    r.t_begin = std::max(highest3(lower(ta, tb)), s.near);
    r.t_exit = lowest3(higher(ta, tb));
    r.face = -1;
    applyCuts(s, eye, direction, r);
    if (r.t_exit <= r.t_begin) return false;
    // A step is at least as long as a pixel is wide.
    r.step_m = std::max(s.step_m, r.t_begin * eye.footprint * float(size));
    r.start = fraction(gpu::kDither.x * fraction(std::floor(at_x * s.width) * gpu::kDither.y +
                                                std::floor(at_y * s.height) * gpu::kDither.z));
    return true;
}

MARCH_FN Float4 softClip(Float4 c) {
    const Float4 over = higher(c - 0.6f, all(0.0f));
    return lower(c, all(0.6f)) + 0.4f * (over / (over + 0.4f));
}

struct RayResult {
    Float4 colour;  // premultiplied
    float depth;    // m; 0: no opaque surface
};

struct ShadedSample {
    Float4 light, tint;
};

// `v`: the sample in the deformed patient, `voxel`: its reference position, both in voxels.
MARCH_FN ShadedSample shadeSample(const Shared& s, const Ray& r, Float4 v, Float4 voxel, Float4 albedo, bool cut) {
    if (cut)
        // A cut surface is lit as a plane.
        return {shade(s, {albedo, 0.0f}, -s.cut[std::size_t(r.face)], r.to_eye), all(1.0f)};
    Float4 slope = gradientAt(s, voxel);
    if (s.moved) slope = turnedByTool(s, s.grid_origin + v * s.spacing, slope);
    if (s.marks == 0 && s.mottle == 0.0f) return {shade(s, {albedo, 0.0f}, slope, r.to_eye), all(1.0f)};
    const Surface skin = surfaceAtVoxel(s, voxel, slope, albedo);
    return {shade(s, skin, slope, r.to_eye), surfaceTint(skin, albedo)};
}

MARCH_FN RayResult marchRay(const Shared& s, const Ray& r, Tally& tally) {
    const float step_t = r.step_m / r.metres;
    const float quarter = step_t / float(kFine), voxel_t = s.voxel_m / r.metres;
    const float t_first = r.t_begin + r.start * step_t;
    const float t_end = s.depth_bounds ? std::min(r.t_exit, r.t_mesh + 0.5f * step_t) : r.t_exit;
    const int last = kFine * int(std::ceil((t_end - t_first) / step_t));
    const float sigma_full = s.sigma_full * r.metres;
    const float steps_per_t = 1.0f / step_t;

    // Weak samples wait for the surface behind them and take its tint, or bare skin would shine through blood.
    Float4 light = all(0.0f), weak = all(0.0f), tint = all(1.0f);
    Float4 weak_voxel = all(0.0f), weak_albedo = all(0.0f);  // of the weightiest weak sample
    float weightiest = 0.0f;
    bool met = false;
    float transmittance = 1.0f, depth = 0.0f;
    std::uint32_t samples = 0, leaps = 0;
    int fine_until = -1, q = 0;
    while (q <= last) {
        const float t = t_first + float(q) * quarter;
        const Float4 v = r.origin + r.direction * t;
        const bool fine = q <= fine_until;
        if (s.empty_space && !fine) {
            const Float4 at = lower(higher((v + 0.5f) * (1.0f / kBrick), all(0.0f)), s.last_brick);
            const Int4 b = __builtin_convertvector(at, Int4);
            const std::uint32_t radius =
                s.brick_distance[std::uint32_t(b[2]) * s.brick_plane + std::uint32_t(b[1]) * s.brick_row +
                                 std::uint32_t(b[0])];
            if (radius > 0) {
                const float t_out = leaveEmpty(r, __builtin_convertvector(b, Float4), float(radius));
                q = std::max(q + kFine, kFine * int(std::ceil((t_out - t_first) * steps_per_t)));
                ++leaps;
                continue;
            }
        }
        const Float4 voxel = s.deforms ? referenceVoxel(s, v) : v;
        const Float4 texel = texelAt(s, voxel);
        ++samples;
        const float a = texel[3];
        if (a == 0.0f) {
            q += q < fine_until ? 1 : kFine;
            continue;
        }
        const float sigma = a * a * sigma_full;
        const bool dense = sigma * step_t > kDense;
        if (!fine && dense) {
            fine_until = q;
            q = std::max(q - kFine + 1, -int(r.start * float(kFine)));
            continue;
        }
        const float width = fine ? quarter : step_t;
        const float inside = std::clamp((r.t_mesh - t) / width + 0.5f, 0.0f, 1.0f);
        const float weight = transmittance * (1.0f - expNegative(sigma * width * inside));
        const Float4 root = texel * (1.0f / std::max(a, 255.0f * 1e-4f));
        const Float4 albedo = root * root;
        if (transmittance * std::min(sigma * voxel_t, 1.0f) > kWeak) {
            const ShadedSample lit =
                shadeSample(s, r, v, voxel, albedo, r.face >= 0 && t - r.t_begin < kCutSteps * step_t);
            tint = lit.tint, met = true;
            light += weight * lit.light + weak * tint;
            weak = all(0.0f);
        } else {
            weak += weight * (albedo * s.weak_light);
            if (weight > weightiest) weightiest = weight, weak_voxel = voxel, weak_albedo = albedo;
        }
        transmittance -= weight;
        if (depth == 0.0f && transmittance < 0.5f) depth = t;
        if (q == fine_until && dense) fine_until += kFine;
        q += q < fine_until ? 1 : kFine;
        if (s.early_termination && transmittance < kOpaque) q = kDone;
    }
    // At the skin's outline no sample is strong.
    if (!met && s.mottle > 0.0f && weightiest > 0.0f)
        tint = surfaceTint(surfaceAtVoxel(s, weak_voxel, gradientAt(s, weak_voxel), weak_albedo), weak_albedo);
    light += weak * tint;
    if (transmittance < kOpaque) transmittance = 0.0f;
    tally.samples += samples;
    tally.leaps += leaps;
    tally.rays += 1;
    tally.terminated += q == kDone;
    tally.bounded += s.depth_bounds && r.t_mesh + 0.5f * step_t < r.t_exit;
    const float opacity = 1.0f - transmittance;
    Float4 colour = softClip(light * (1.0f / std::max(opacity, 1e-4f))) * opacity;
    colour[3] = opacity;
    return {colour, depth};
}

// Number of pixels along either axis that share a ray in the tile around a point.
MARCH_FN std::uint32_t raySize(const Shared& s, const EyeRays& eye, float at_x, float at_y) {
    if (!s.foveate) return 1;
    const glm::vec4& t = eye.tangents;
    const float x = t.x + (t.y - t.x) * at_x, y = t.z + (t.w - t.z) * at_y;
    const float away = std::sqrt(x * x + y * y);
    return away > s.fovea_sixteenth ? 4 : away > s.fovea_quarter ? 2 : 1;
}

MARCH_FN RayResult marchAt(const Shared& s, const Tile& tile, float at_x, float at_y, std::uint32_t size,
                         Tally& tally) {
    Ray r;
    if (!makeRay(s, s.eyes[tile.eye], at_x, at_y, size, r)) return {all(0.0f), 0.0f};
    float d = 0.0f;
    if (s.mesh_depth) {
        const auto x = std::min(std::uint32_t(at_x * float(s.mesh_width)), s.mesh_width - 1);
        const auto y = std::min(std::uint32_t(at_y * float(s.mesh_height)), s.mesh_height - 1);
        d = s.mesh_depth[(std::size_t(tile.eye) * s.mesh_height + y) * s.mesh_width + x];
    }
    r.t_mesh = s.near * s.far / (s.near + d * (s.far - s.near));
    return marchRay(s, r, tally);
}

MARCH_TARGET void marchTile(const Shared& s, const Tile& tile, Tally& tally) {
    const float middle = 0.5f * float(gpu::kTile);
    const std::uint32_t size =
        raySize(s, s.eyes[tile.eye], (float(tile.x) + middle) / s.width, (float(tile.y) + middle) / s.height);
    const std::uint32_t x_end = std::min(tile.x + std::uint32_t(gpu::kTile), s.columns);
    const std::uint32_t y_end = std::min(tile.y + std::uint32_t(gpu::kTile), s.rows);
    for (std::uint32_t y = tile.y; y < y_end; y += size)
        for (std::uint32_t x = tile.x; x < x_end; x += size) {
            const float half = 0.5f * float(size);
            const RayResult seen = marchAt(s, tile, std::min((float(x) + half) / s.width, 1.0f),
                                         std::min((float(y) + half) / s.height, 1.0f), size, tally);
            for (std::uint32_t to_y = y; to_y < std::min(y + size, y_end); ++to_y)
                for (std::uint32_t to_x = x; to_x < std::min(x + size, x_end); ++to_x) {
                    const std::size_t at = (std::size_t(tile.eye) * s.rows + to_y) * s.columns + to_x;
                    storeHalf(s.colour + at, seen.colour);
                    s.depth[at] = seen.depth;
                }
        }
}
