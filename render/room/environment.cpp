#include "render/room/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace stylet::render {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr int kIrradianceRings = 48;
// Samples per lobe. In a wide lobe, more of them miss the panels.
constexpr int kNarrow = 64, kWide = 512;

// Linear radiance. The panels are far brighter than the surfaces that they light.
constexpr glm::vec3 kPanel{2.05f, 2.32f, 2.42f};
constexpr glm::vec3 kCeiling{0.20f, 0.235f, 0.24f}, kWall{0.165f, 0.205f, 0.21f}, kBand{0.05f, 0.12f, 0.135f};
constexpr glm::vec3 kFloor{0.115f, 0.13f, 0.135f}, kUnderTable{0.05f, 0.06f, 0.065f};
constexpr float kPanelX_m[2] = {-1.55f, 1.55f}, kPanelZ_m[3] = {-1.7f, 0.0f, 1.7f};
constexpr float kPanelHalfX_m = 0.30f, kPanelHalfZ_m = 0.60f;

glm::vec3 ceilingAt(const glm::vec3& p) {
    for (const float x : kPanelX_m)
        for (const float z : kPanelZ_m)
            if (std::fabs(p.x - x) < kPanelHalfX_m && std::fabs(p.z - z) < kPanelHalfZ_m) return kPanel;
    return kCeiling;
}

glm::vec3 floorAt(const glm::vec3& p) {
    const float away = std::max(std::fabs(p.x) - 0.30f, std::fabs(p.z) - 0.9f);
    return glm::mix(kUnderTable, kFloor, std::clamp(away / 0.8f + 0.4f, 0.0f, 1.0f));
}

// Radical inverse in base 2, for evenly spread samples.
float inverted(std::uint32_t i) {
    float x = 0.0f, digit = 0.5f;
    for (; i != 0; i >>= 1, digit *= 0.5f)
        if (i & 1) x += digit;
    return x;
}

std::array<float, 9> basis(const glm::vec3& n) {
    return {0.282095f,
            0.488603f * n.y,
            0.488603f * n.z,
            0.488603f * n.x,
            1.092548f * n.x * n.y,
            1.092548f * n.y * n.z,
            0.315392f * (3.0f * n.z * n.z - 1.0f),
            1.092548f * n.x * n.z,
            0.546274f * (n.x * n.x - n.y * n.y)};
}

// Factor by which a cosine lobe scales each band, divided by pi.
constexpr std::array<float, 9> kCosine{1.0f, 2.0f / 3, 2.0f / 3, 2.0f / 3, 0.25f, 0.25f, 0.25f, 0.25f, 0.25f};

std::array<glm::vec3, 9> gatherIrradiance() {
    std::array<glm::vec3, 9> sum{};
    constexpr int kAround = 2 * kIrradianceRings;
    for (int ring = 0; ring < kIrradianceRings; ++ring)
        for (int i = 0; i < kAround; ++i) {
            // Samples of equal area: uniform in height and in angle.
            const float z = -1.0f + (2.0f * float(ring) + 1.0f) / kIrradianceRings;
            const float angle = 2.0f * kPi * (float(i) + 0.5f) / kAround, r = std::sqrt(1.0f - z * z);
            const glm::vec3 d(r * std::cos(angle), z, r * std::sin(angle));
            const glm::vec3 light =
                roomRadiance(kGatherPoint, d) * (4.0f * kPi / (kIrradianceRings * kAround));
            const auto y = basis(d);
            for (std::size_t k = 0; k < 9; ++k)
                sum[k] += light * y[k] * kCosine[k];
        }
    return sum;
}

// Mean radiance over the GGX lobe about a mirrored direction. Assumes that the viewer looks from that
// direction too.
glm::vec3 blurred(const glm::vec3& n, float roughness) {
    if (roughness == 0.0f) return roomRadiance(kGatherPoint, n);
    const float a = roughness * roughness;
    const glm::vec3 side =
        glm::normalize(glm::cross(std::fabs(n.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0), n));
    const glm::vec3 up = glm::cross(n, side);
    const int samples = roughness < 0.5f ? kNarrow : kWide;
    glm::vec3 sum(0.0f);
    float weights = 0.0f;
    for (int i = 0; i < samples; ++i) {
        const float u = (float(i) + 0.5f) / float(samples), phi = 2.0f * kPi * inverted(std::uint32_t(i));
        const float cosine = std::sqrt((1.0f - u) / (1.0f + (a * a - 1.0f) * u));
        const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
        const glm::vec3 half = sine * std::cos(phi) * side + sine * std::sin(phi) * up + cosine * n;
        const glm::vec3 way = 2.0f * cosine * half - n;
        const float weight = glm::dot(n, way);
        if (weight <= 0.0f) continue;
        sum += weight * roomRadiance(kGatherPoint, glm::normalize(way));
        weights += weight;
    }
    return sum / weights;
}

// Interpolates along the computed rows first, then between them.
void fillBetween(glm::vec3* out, int n, int stride) {
    const auto share = [&](int i) { return float(i % stride) / float(stride); };
    const auto low = [&](int i) { return i - i % stride; };
    const auto high = [&](int i) { return std::min(low(i) + stride, n - 1); };
    for (int y = 0; y < n; y += stride)
        for (int x = 0; x < n; ++x)
            out[y * n + x] = glm::mix(out[y * n + low(x)], out[y * n + high(x)], share(x));
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
            out[y * n + x] = glm::mix(out[low(y) * n + x], out[high(y) * n + x], share(y));
}

}  // namespace

glm::vec3 roomRadiance(const glm::vec3& from_m, const glm::vec3& d) {
    const glm::vec3 middle(0.0f, kRoomHalf.y, 0.0f);
    const auto wallDistance = [&](int axis) {
        const float side = std::copysign(kRoomHalf[axis], d[axis]);
        return std::fabs(d[axis]) < 1e-6f ? 1e9f : (side + middle[axis] - from_m[axis]) / d[axis];
    };
    const glm::vec3 t(wallDistance(0), wallDistance(1), wallDistance(2));
    const float nearest = std::min({t.x, t.y, t.z});
    const glm::vec3 p = from_m + nearest * d;
    if (nearest == t.y) return d.y > 0.0f ? ceilingAt(p) : floorAt(p);
    if (p.y > 0.94f && p.y < 1.12f) return kBand;
    return kWall * (0.72f + 0.28f * p.y / (2.0f * kRoomHalf.y));
}

glm::vec2 octahedralFromDirection(const glm::vec3& d) {
    const float sum = std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z);
    const glm::vec2 p = glm::vec2(d.x, d.z) / sum;
    if (d.y >= 0.0f) return p;
    return {(1.0f - std::fabs(p.y)) * std::copysign(1.0f, p.x),
            (1.0f - std::fabs(p.x)) * std::copysign(1.0f, p.y)};
}

glm::vec3 directionFromOctahedral(const glm::vec2& p) {
    glm::vec3 d(p.x, 1.0f - std::fabs(p.x) - std::fabs(p.y), p.y);
    const float fold = std::max(-d.y, 0.0f);
    d.x -= std::copysign(fold, d.x);
    d.z -= std::copysign(fold, d.z);
    return glm::normalize(d);
}

glm::vec3 irradianceAt(const std::array<glm::vec3, 9>& irradiance, const glm::vec3& normal) {
    const auto y = basis(normal);
    glm::vec3 sum(0.0f);
    for (std::size_t k = 0; k < 9; ++k)
        sum += irradiance[k] * y[k];
    return sum;
}

Environment makeEnvironment() {
    constexpr int n = Environment::kSize;
    Environment made;
    made.irradiance = gatherIrradiance();
    made.texels.resize(std::size_t(n) * n * Environment::kLevels);
    for (int level = 0; level < Environment::kLevels; ++level) {
        const float roughness = float(level) / (Environment::kLevels - 1);
        // Such blurred levels have no detail: compute every third texel and interpolate linearly.
        const int stride = roughness < 0.5f ? 1 : 3;
        static_assert((n - 1) % 3 == 0);
        glm::vec3* out = &made.texels[std::size_t(level) * n * n];
        for (int y = 0; y < n; y += stride)
            for (int x = 0; x < n; x += stride)
                out[y * n + x] =
                    blurred(directionFromOctahedral(2.0f * glm::vec2(x, y) / float(n - 1) - 1.0f), roughness);
        if (stride > 1) fillBetween(out, n, stride);
    }
    return made;
}

}  // namespace stylet::render
