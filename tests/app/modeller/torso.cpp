#include "tests/app/modeller/torso.h"

#include <cmath>

namespace stylet::test {

namespace {

constexpr double kHalfWidth_m = 0.130, kHalfDepth_m = 0.095;
const Vec3 kLiver_m{0.050, 0.005, 0.095}, kLiverAxes_m{0.062, 0.045, 0.060};

double toSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const double t = glm::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
    return glm::length(p - glm::mix(a, b, t));
}

bool inPortal(const Vec3& p) {
    const Vec3 fork{0.045, 0.0, 0.095};
    if (toSegment(p, {-0.03, 0.0, 0.075}, fork) < 0.005) return true;
    for (const Vec3& end : {Vec3(0.090, 0.015, 0.115), Vec3(0.085, -0.020, 0.105), Vec3(0.075, 0.010, 0.065),
                            Vec3(0.050, 0.030, 0.100)})
        if (toSegment(p, fork, end) < 0.003) return true;
    return false;
}

// Returns true inside the ribs: rings of bone in the body wall, every 26 mm.
bool inRib(const Vec3& p, double inward_m) {
    const double off = std::fmod(p.z + 0.013, 0.026) - 0.013;
    return std::hypot(off, inward_m - 0.030) < 0.005;
}

}  // namespace

Torso makeTorso() {
    const Grid grid{{150, 116, 64}, {0.002, 0.002, 0.003}, {-0.150, -0.115, 0.0}};
    Torso t{CtVolume(grid), Volume<std::int16_t>(grid), {}};
    std::uint32_t seed = 1;
    forEachVoxel(grid, [&](const Index3& i) {
        const Vec3 p = grid.centre(i);
        const double r = std::hypot(p.x / kHalfWidth_m, p.y / kHalfDepth_m);
        const double inward_m = (1.0 - r) * std::hypot(p.x, p.y) / std::max(r, 1e-6);
        seed = seed * 1664525u + 1013904223u;
        const int noise = int(seed >> 28) - 8;
        int hu = -1000, id = 0;
        if (r < 1.0) {
            id = 1;
            hu = inward_m < 0.022 ? -100 : inward_m < 0.038 ? 55 : 30;
            if (inRib(p, inward_m)) hu = 450, id = 65;
            const Vec3 l = (p - kLiver_m) / kLiverAxes_m;
            if (glm::dot(l, l) < 1.0) hu = 110, id = 7;
            if (inPortal(p)) hu = 160, id = 465;
        } else if (std::fabs(p.y + 0.105) < 0.002 && std::fabs(p.x) < 0.12) {
            hu = 200;  // the table
        }
        t.ct[i] = std::int16_t(hu + (hu > -500 ? noise : 0));
        t.labels[i] = std::int16_t(id);
    });
    using modeller::targetId;
    t.map.target_of = {
        {1, 0}, {7, targetId("liver")}, {65, targetId("bone")}, {465, targetId("portal vein")}};
    t.map.source = "phantom";
    t.map.licence = "CC0";
    return t;
}

}  // namespace stylet::test
