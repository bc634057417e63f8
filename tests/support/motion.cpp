#include "tests/support/motion.h"

#include <cmath>

#include "base/smoothstep.h"

namespace stylet::test {

namespace {

std::array<float, 3> narrowed(const Vec3& v) {
    return {float(v.x), float(v.y), float(v.z)};
}

}  // namespace

patient::MotionModel makeMotion(const Vec3& half_m, double spacing_m,
                                const std::function<MotionPoint(const Vec3&)>& at) {
    patient::MotionModel m;
    m.grid.dims = 2 * Index3(glm::ceil(half_m / spacing_m - 1e-9)) + 1;
    m.grid.spacing_m = Vec3(spacing_m);
    m.grid.origin_m = -0.5 * spacing_m * Vec3(m.grid.dims - 1);
    forEachVoxel(m.grid, [&](const Index3& i) {
        const MotionPoint p = at(m.grid.centre(i));
        const double inner = m.grid.atBorder(i) ? 0.0 : 1.0;
        m.wall.push_back({narrowed(inner * p.wall_a1_m), narrowed(inner * p.wall_a2_m_s)});
        m.slide.push_back({narrowed(inner * p.slide_a1_m), narrowed(inner * p.slide_a2_m_s)});
        m.level_m.push_back(float(p.level_m));
    });
    return m;
}

patient::MotionModel makeShift(double travel_m) {
    return makeMotion(Vec3(0.3), 0.1, [&](const Vec3&) {
        MotionPoint p;
        p.slide_a1_m.z = travel_m;
        return p;
    });
}

patient::MotionModel makeTurningBall(double radius_m, double angle_rad, double spacing_m) {
    return makeMotion(Vec3(1.6 * radius_m), spacing_m, [&](const Vec3& p) {
        MotionPoint q;
        q.level_m = std::sqrt(glm::dot(p, p)) - radius_m;
        const double near = 1.0 - smoothStep(1.3 * radius_m, 1.5 * radius_m, std::sqrt(glm::dot(p, p)));
        q.slide_a1_m = near * angle_rad * Vec3(-p.y, p.x, 0.0);
        return q;
    });
}

patient::MotionModel makeBending() {
    return makeMotion(Vec3(0.12), 0.006, [](const Vec3& p) {
        MotionPoint q;
        q.slide_a1_m = {0.004 * std::sin(40.0 * p.z), 0.003 * std::cos(35.0 * p.x),
                        -0.015 * std::cos(25.0 * p.x)};
        q.slide_a2_m_s = {0.0, 0.001 * std::sin(30.0 * p.z), 0.001};
        q.wall_a1_m = {0.003 * std::cos(30.0 * p.x), 0.002 * std::sin(30.0 * p.x), 0.0};
        return q;
    });
}

}  // namespace stylet::test
