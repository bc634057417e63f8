// Based on Levoy, "Display of surfaces from volume data", 1988, and Deakin and Knoll, "Efficient ray
// casting of volumetric images using distance maps for empty space skipping", 2020. The same algorithm as
// volume.comp.
#include "render/volume/march.h"

#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>

#include <glm/gtc/packing.hpp>

#include "render/volume/lanes.h"
#include "render/volume/march_shared.h"

namespace stylet::render {
namespace {

using gpu::kBloodRun, gpu::kBloodWaver_m, gpu::kIodineWaver_m, gpu::kIodineGrain_m, gpu::kMarkDepth_m;
using gpu::kBrick, gpu::kOpaque, gpu::kDone, gpu::kFine, gpu::kDense, gpu::kWeak, gpu::kSurface;
using gpu::kCutSteps, gpu::kGrazingLight, gpu::kLeastAlbedo, gpu::kTurnedAway, gpu::kWetPower,
    gpu::kWetStrength;
using gpu::kFleshFrom_m, gpu::kFleshTo_m, gpu::kWoundFrom_m, gpu::kWoundTo_m;
using gpu::kMottleCoarse_m, gpu::kMottleFine_m, gpu::kPore_m;

constexpr Float4 float3(const glm::vec3& v, float w = 0.0f) {
    return Float4{v.x, v.y, v.z, w};
}

constexpr Float4 kWound = float3(gpu::kWound), kFlesh = float3(gpu::kFlesh), kStain = float3(gpu::kStain),
                 kFreshBlood = float3(gpu::kFreshBlood), kFlush = float3(gpu::kFlush);

struct EyeRays {
    Float4 origin, place;  // position of the eye: voxels; patient frame, m
    // Direction of the ray through the top left corner; its change over a whole row and column.
    Float4 corner, across, down;
    glm::vec4 tangents;
    float footprint;  // size of a pixel per metre of depth
};

struct PlacedMark {
    Float4 place, along;
    float size, kind;
};

// Grid of a deformation table: nodes = point * scale + offset.
struct NodeGrid {
    Float4 scale, offset, last;
    Int4 last_low;
    std::size_t row, plane;
};

// Data of a frame for its rays, precomputed once.
struct Shared {
    std::array<EyeRays, 2> eyes;
    Float4 dims, last_cell, spacing, per_spacing, grid_origin, last_brick;
    NodeGrid breath, tool;
    Float4 key_direction, key, up, sky, ground, weak_light, tint, gradient_scale;
    float width, height, near, far;
    float step_m, voxel_m, sigma_full, gradient_voxels;
    float wrap, specular, specular_power, rim, mottle, pores;
    const std::uint32_t* texels;
    std::size_t row, plane;
    const std::uint32_t* brick_distance;
    std::uint32_t brick_row, brick_plane;
    const glm::vec4 *inside, *outside, *moved;  // null: no breath, no tool
    float tool_half_node;
    const float* mesh_depth;
    std::uint32_t mesh_width, mesh_height;
    std::uint64_t* colour;
    float* depth;
    std::uint32_t columns, rows;
    std::array<Float4, gpu::kMaxCuts> cut;
    std::array<PlacedMark, gpu::kMaxMarks> mark;
    int cuts, marks;
    float fovea_quarter, fovea_sixteenth;
    bool empty_space, early_termination, depth_bounds, foveate, deforms;
};

struct Tile {
    std::uint32_t eye, x, y;  // x, y: its first pixel
};

struct Tally {
    std::uint64_t samples = 0, rays = 0, leaps = 0, terminated = 0, bounded = 0;
};

#if defined(__x86_64__)
namespace wide {

#define MARCH_TARGET __attribute__((target("avx2,fma,f16c")))
#define MARCH_FN MARCH_TARGET __attribute__((always_inline)) inline

MARCH_FN Float4 lower(Float4 a, Float4 b) {
    return _mm_min_ps(a, b);
}
MARCH_FN Float4 higher(Float4 a, Float4 b) {
    return _mm_max_ps(a, b);
}

using avx2::blend;
using avx2::fetchNode;

MARCH_FN __m256 pairAt(const std::uint32_t* p) {
    const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(p));
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
}

MARCH_FN Float4 fetchTexel(const std::uint32_t* p, std::size_t row, std::size_t plane, Float4 f) {
    return blend(pairAt(p), pairAt(p + row), pairAt(p + plane), pairAt(p + plane + row), f);
}

// Fetches only the opacity: half the work.
MARCH_FN float fetchOpacity(const std::uint32_t* p, std::size_t row, std::size_t plane, Float4 f) {
    const auto twoAt = [](const std::uint32_t* at) __attribute__((target("avx2,fma,f16c"), always_inline)) {
        return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(at));
    };
    const __m128i near = _mm_unpacklo_epi64(twoAt(p), twoAt(p + row));
    const __m128i far = _mm_unpacklo_epi64(twoAt(p + plane), twoAt(p + plane + row));
    const __m128 a = _mm_cvtepi32_ps(_mm_srli_epi32(near, 24)), b = _mm_cvtepi32_ps(_mm_srli_epi32(far, 24));
    const __m128 along_z = _mm_fmadd_ps(_mm_shuffle_ps(f, f, 0xaa), _mm_sub_ps(b, a), a);
    const __m128 high = _mm_movehl_ps(along_z, along_z);
    const __m128 along_y = _mm_fmadd_ps(_mm_shuffle_ps(f, f, 0x55), _mm_sub_ps(high, along_z), along_z);
    return along_y[0] + f[0] * (along_y[1] - along_y[0]);
}

MARCH_FN void storeHalf(std::uint64_t* out, Float4 colour) {
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out), _mm_cvtps_ph(colour, _MM_FROUND_TO_NEAREST_INT));
}

#include "render/volume/march_core.inl"

#undef MARCH_FN
#undef MARCH_TARGET

}  // namespace wide
#endif

namespace portable {

#define MARCH_TARGET
#define MARCH_FN inline

MARCH_FN Float4 lower(Float4 a, Float4 b) {
    return a < b ? a : b;
}
MARCH_FN Float4 higher(Float4 a, Float4 b) {
    return a > b ? a : b;
}

using scalar::fetchNode;

MARCH_FN Float4 fetchTexel(const std::uint32_t* p, std::size_t row, std::size_t plane, Float4 f) {
    return scalar::fetch(p, 1, row, plane, f);
}
MARCH_FN float fetchOpacity(const std::uint32_t* p, std::size_t row, std::size_t plane, Float4 f) {
    return fetchTexel(p, row, plane, f)[3];
}
MARCH_FN void storeHalf(std::uint64_t* out, Float4 colour) {
    *out = glm::packHalf4x16(glm::vec4(colour[0], colour[1], colour[2], colour[3]));
}

#include "render/volume/march_core.inl"

#undef MARCH_FN
#undef MARCH_TARGET

}  // namespace portable

EyeRays eyeRays(const gpu::EyeUniforms& eye, const gpu::FrameUniforms& frame) {
    const glm::mat4& m = eye.patient_from_eye;
    const auto direction = [&](float x, float y, float z) { return m[0] * x + m[1] * y + m[2] * z; };
    const glm::vec4 t = eye.tangents;
    const glm::vec4 origin = (m[3] - frame.grid_origin) / frame.grid_spacing;
    return {.origin = float3(origin),
            .place = float3(m[3]),
            .corner = float3(direction(t.x, t.z, -1.0f)),
            .across = float3(direction(t.y - t.x, 0.0f, 0.0f)),
            .down = float3(direction(0.0f, t.w - t.z, 0.0f)),
            .tangents = t,
            .footprint = frame.fovea.z * std::max(std::fabs(t.y - t.x) / frame.layer.x,
                                                  std::fabs(t.w - t.z) / frame.layer.y)};
}

void setLight(Shared& s, const gpu::FrameUniforms& frame, const gpu::LookUniforms& look) {
    s.key_direction = float3(frame.key_patient);
    s.key = float3(gpu::kKeyColour) * frame.key_patient.w;
    s.up = float3(frame.up_patient);
    s.sky = float3(gpu::kSkyColour), s.ground = float3(gpu::kGroundColour);
    s.weak_light = 0.5f * (s.sky + s.ground) + gpu::kWeakKey * s.key;
    s.tint = float3(look.tint);
    s.wrap = look.surface.x, s.specular = look.surface.y, s.specular_power = look.surface.z;
    s.rim = look.surface.w;
    s.mottle = look.detail.x, s.pores = look.detail.y;
    s.gradient_voxels = look.tint.w;
    const Float4 spacing = float3(frame.grid_spacing, 1.0f);
    s.gradient_scale = 0.5f / look.tint.w * s.voxel_m / 255.0f / spacing;
    s.gradient_scale[3] = 0.0f;
}

NodeGrid nodeGrid(const Grid& grid) {
    const glm::vec3 scale(1.0 / grid.spacing_m), offset(-grid.origin_m / grid.spacing_m);
    const Int4 last_low = {grid.dims.x - 2, grid.dims.y - 2, grid.dims.z - 2, 0};
    const auto row = std::size_t(grid.dims.x);
    return {.scale = Float4{scale.x, scale.y, scale.z, 0.0f},
            .offset = Float4{offset.x, offset.y, offset.z, 0.0f},
            .last = __builtin_convertvector(last_low, Float4) + Float4{1.0f, 1.0f, 1.0f, 0.0f},
            .last_low = last_low,
            .row = row,
            .plane = row * std::size_t(grid.dims.y)};
}

void setDeformation(Shared& s, const DeformTables* breath, const patient::DisplacementTable* tool) {
    if (breath) {
        s.breath = nodeGrid(breath->grid);
        s.inside = breath->inside.data(), s.outside = breath->outside.data();
    }
    if (tool) {
        s.tool = nodeGrid(tool->grid);
        s.moved = tool->moved_m.data();
        s.tool_half_node = float(0.5 * tool->grid.spacing_m.x);
    }
    s.deforms = breath || tool;
}

void setSurgery(Shared& s, const gpu::FrameUniforms& frame) {
    s.cuts = int(frame.layer.z), s.marks = int(frame.layer.w);
    for (std::size_t i = 0; i < std::size_t(s.cuts); ++i)
        s.cut[i] = float3(frame.cuts[i], frame.cuts[i].w);
    for (std::size_t i = 0; i < std::size_t(s.marks); ++i) {
        const gpu::MarkUniforms& mark = frame.marks[i];
        s.mark[i] = {float3(mark.place), float3(mark.shape), mark.place.w, mark.shape.w};
    }
}

Shared makeShared(const MarchInput& in, const MarchOutput& out) {
    const gpu::FrameUniforms& frame = in.frame;
    Shared s{};
    s.spacing = float3(frame.grid_spacing, 0.0f);
    s.per_spacing = 1.0f / float3(frame.grid_spacing, 1.0f);
    s.per_spacing[3] = 0.0f;
    s.grid_origin = float3(frame.grid_origin);
    s.voxel_m = std::min({s.spacing[0], s.spacing[1], s.spacing[2]});
    s.step_m = frame.grid_spacing.w * s.voxel_m;
    s.dims = float3(frame.grid_dims);
    s.last_cell = float3(frame.grid_dims) + Float4{1.0f, 1.0f, 1.0f, 0.0f};
    s.sigma_full = frame.grid_dims.w / (255.0f * 255.0f);
    for (std::size_t eye = 0; eye < 2; ++eye)
        s.eyes[eye] = eyeRays(frame.eyes[eye], frame);
    s.width = frame.layer.x, s.height = frame.layer.y, s.near = frame.target.z, s.far = frame.target.w;
    s.columns = std::uint32_t(frame.layer.x), s.rows = std::uint32_t(frame.layer.y);
    s.mesh_width = std::uint32_t(frame.target.x), s.mesh_height = std::uint32_t(frame.target.y);
    s.foveate = frame.fovea.y > 0.0f;
    s.fovea_quarter = frame.fovea.x, s.fovea_sixteenth = frame.fovea.y;
    s.texels = in.volume.texels(), s.row = in.volume.row(), s.plane = in.volume.plane();
    s.brick_distance = in.brick_distance.data();
    s.last_brick = float3(frame.brick_dims) - Float4{1.0f, 1.0f, 1.0f, 0.0f};
    s.brick_row = std::uint32_t(frame.brick_dims.x);
    s.brick_plane = s.brick_row * std::uint32_t(frame.brick_dims.y);
    s.mesh_depth = in.mesh_depth.empty() ? nullptr : in.mesh_depth.data();
    s.colour = out.colour, s.depth = out.depth;
    s.empty_space = in.skips.empty_space && !in.brick_distance.empty();
    s.early_termination = in.skips.early_termination;
    s.depth_bounds = in.skips.depth_bounds;
    setLight(s, frame, in.look);
    setDeformation(s, in.deformation, in.tool);
    setSurgery(s, frame);
    return s;
}

using MarchTile = void (*)(const Shared&, const Tile&, Tally&);

MarchTile tileFunction(MarchPath path) {
#if defined(__x86_64__)
    const bool able =
        __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("f16c");
    if (path == MarchPath::widest && able) return wide::marchTile;
#endif
    return portable::marchTile;
}

}  // namespace

void MarchVolume::Free::operator()(std::uint32_t* p) const {
    std::free(p);
}

MarchVolume::MarchVolume(const Index3& dims) : dims_(dims) {
    constexpr std::size_t kHugePage = std::size_t(1) << 21;
    const std::size_t bytes = plane() * (std::size_t(dims.z) + 3) * sizeof(std::uint32_t);
    const std::size_t rounded = (bytes + kHugePage - 1) / kHugePage * kHugePage;
    void* memory = std::aligned_alloc(kHugePage, rounded);
    if (!memory) throw std::bad_alloc();
#if defined(__linux__)
    // A sample reads four distant rows. If huge pages are refused, the march is only slower.
    madvise(memory, rounded, MADV_HUGEPAGE);
#endif
    std::memset(memory, 0, rounded);
    texels_.reset(static_cast<std::uint32_t*>(memory));
}

void MarchVolume::setPlanes(int z0, int z1, const std::byte* rgba) {
    const std::size_t bytes = std::size_t(dims_.x) * sizeof(std::uint32_t);
    for (int z = z0; z < z1; ++z)
        for (int y = 0; y < dims_.y; ++y, rgba += bytes)
            std::memcpy(texels_.get() + std::size_t(z + 1) * plane() + std::size_t(y + 1) * row() + 1, rgba,
                        bytes);
}

gpu::Counters march(Workers& workers, const MarchInput& in, const MarchOutput& out, MarchPath path) {
    const Shared shared = makeShared(in, out);
    const MarchTile marchTile = tileFunction(path);
    const auto tiles = [](std::uint32_t pixels) { return (pixels + gpu::kTile - 1) / gpu::kTile; };
    const std::size_t columns = tiles(shared.columns), of_eye = columns * tiles(shared.rows);
    std::atomic<std::uint64_t> samples{0}, rays{0}, leaps{0}, terminated{0}, bounded{0};
    workers.run(of_eye * in.eyes, [&](std::size_t job, int) {
        const std::size_t at = job % of_eye;
        Tally tally;
        marchTile(shared,
                  {.eye = std::uint32_t(job / of_eye),
                   .x = std::uint32_t(at % columns) * gpu::kTile,
                   .y = std::uint32_t(at / columns) * gpu::kTile},
                  tally);
        if (!in.count) return;
        constexpr auto relaxed = std::memory_order_relaxed;
        samples.fetch_add(tally.samples, relaxed);
        rays.fetch_add(tally.rays, relaxed);
        leaps.fetch_add(tally.leaps, relaxed);
        terminated.fetch_add(tally.terminated, relaxed);
        bounded.fetch_add(tally.bounded, relaxed);
    });
    gpu::Counters counted{};
    counted.samples = std::uint32_t(samples), counted.samples_high = std::uint32_t(samples >> 32);
    counted.rays = std::uint32_t(rays);
    counted.skipped_bricks = std::uint32_t(leaps);
    counted.terminated_rays = std::uint32_t(terminated);
    counted.depth_bounded_rays = std::uint32_t(bounded);
    return counted;
}

}  // namespace stylet::render
