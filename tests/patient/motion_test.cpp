#include "patient/motion/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "base/smoothstep.h"
#include "patient/motion/motion_interface.h"
#include "tests/support/constants.h"
#include "tests/support/motion.h"

namespace stylet::patient {
namespace {

using test::kMm;
using test::makeMotion;
using test::MotionPoint;

const Surrogate kFull{1.0, 0.0};

// A barrel that slides down by 15 mm inside a shell, with hysteresis. The shell's front moves out by 5 mm.
MotionModel barrel(double scale = 1.0) {
    MotionModel m = makeMotion(Vec3(0.17, 0.15, 0.19), 0.006, [&](const Vec3& p) {
        MotionPoint q;
        const double waist = 1.0 - 0.15 * (p.z / 0.15) * (p.z / 0.15);
        q.level_m = (std::sqrt(p.x * p.x / 0.0144 + p.y * p.y / 0.0064) - waist) * 0.08;
        const double along = smoothStep(-0.17, -0.06, p.z) * smoothStep(0.17, 0.06, p.z);
        q.slide_a1_m = scale * along * Vec3(0.0, 0.003, -0.015);
        q.slide_a2_m_s = scale * along * Vec3(0.0, 0.0, -0.001);
        q.wall_a1_m.y = scale * 0.005 * smoothStep(0.0, 0.08, p.y) * smoothStep(0.145, 0.10, p.y) *
                        smoothStep(-0.17, -0.05, p.z) * smoothStep(0.17, 0.05, p.z) *
                        smoothStep(0.16, 0.10, std::fabs(p.x));
        return q;
    });
    makeTangential(m);
    return m;
}

struct Anywhere {
    std::mt19937 random{11};
    Vec3 half_m{0.19, 0.17, 0.21};
    double next(double half) { return half * (2.0 * double(random()) / 4294967296.0 - 1.0); }
    Vec3 point() { return {next(half_m.x), next(half_m.y), next(half_m.z)}; }
};

const std::vector<Surrogate> kBreaths = {{0.0, 0.0}, {0.3, 1.2}, {1.0, 0.0}, {0.6, -1.5}, {1.2, 0.5}};

TEST(Motion, ConstantFieldTranslates) {
    const MotionModel m = test::makeShift(-0.020);
    EXPECT_NEAR(
        glm::distance(deformedFromReference(m, kFull, Vec3(0.01, 0.02, 0.03)), Vec3(0.01, 0.02, 0.01)), 0.0,
        1e-9);
    EXPECT_NEAR(glm::distance(referenceFromDeformed(m, {0.5, 0.0}, Vec3(0.0)), Vec3(0.0, 0.0, 0.01)), 0.0,
                1e-9);
}

// The exponential of a rotation's field is the rotation. A midpoint step of angle a has an error of a^3 / 24.
TEST(Motion, RotationalFieldRotates) {
    const MotionModel m = test::makeTurningBall(0.06, 0.3, 0.006);
    Anywhere anywhere;
    anywhere.half_m = Vec3(0.03);
    for (const double v : {0.25, 1.0}) {
        const double c = std::cos(0.3 * v), s = std::sin(0.3 * v);
        for (int i = 0; i < 500; ++i) {
            const Vec3 p = anywhere.point();
            const Vec3 turned(c * p.x - s * p.y, s * p.x + c * p.y, p.z);
            EXPECT_LT(glm::distance(deformedFromReference(m, {v, 0.0}, p), turned), 0.015 * kMm);
            EXPECT_LT(glm::distance(referenceFromDeformed(m, {v, 0.0}, turned), p), 0.015 * kMm);
        }
        const Mat3 j = motionJacobian(m, {v, 0.0}, Vec3(0.01, 0.005, 0.0));
        EXPECT_NEAR(j[0][0], c, 1e-3);
        EXPECT_NEAR(j[0][1], s, 1e-3);
        EXPECT_NEAR(glm::determinant(j), 1.0, 1e-3);
    }
}

TEST(Motion, IsRelativeToTheBreathOfTheCtAndClamped) {
    MotionModel m = test::makeShift(-0.020);
    m.reference = {1.0, 0.0};
    m.v = {0.0, 1.25};
    EXPECT_EQ(deformedFromReference(m, m.reference, Vec3(0.01)), Vec3(0.01));
    EXPECT_EQ(referenceFromDeformed(m, m.reference, Vec3(0.01)), Vec3(0.01));
    EXPECT_NEAR(deformedFromReference(m, {0.0, 0.0}, Vec3(0.0)).z, 0.020, 1e-9);
    EXPECT_EQ(deformedFromReference(m, {-7.0, 0.0}, Vec3(0.0)),
              deformedFromReference(m, {0.0, 0.0}, Vec3(0.0)));
    EXPECT_EQ(deformedFromReference(m, {9.0, 0.0}, Vec3(0.0)),
              deformedFromReference(m, {1.25, 0.0}, Vec3(0.0)));
    // Creep is added after clamping: 5.6 mm toward the head at 20 mm of travel.
    EXPECT_NEAR(deformedFromReference(m, {-7.0, 0.0, -0.28}, Vec3(0.0)).z, 0.0256, 1e-9);
    m.rate_per_s = {-1.0, 2.0};
    for (MotionCoefficients& c : m.slide)
        c.a2_m_s[2] = c.a1_m[2] / 10.0f;
    EXPECT_NEAR(deformedFromReference(m, {1.0, 50.0}, Vec3(0.0)).z, -0.004, 1e-9);
    EXPECT_NEAR(deformedFromReference(m, {1.0, -50.0}, Vec3(0.0)).z, 0.002, 1e-9);
}

TEST(Motion, InverseReturnsEveryPointOnItsSide) {
    const MotionModel m = barrel();
    Anywhere anywhere;
    for (const Surrogate& breath : kBreaths) {
        double worst_m = 0.0;
        for (int i = 0; i < 20000; ++i) {
            const Vec3 p = anywhere.point();
            if (std::fabs(cavityLevel_m(m, p)) < 0.5 * kMm) continue;  // excludes gaps between the sides
            const Vec3 q = deformedFromReference(m, breath, p);
            worst_m = std::max(worst_m, glm::distance(referenceFromDeformed(m, breath, q), p));
            EXPECT_EQ(cavityLevel_m(m, breath, q) < 0.0, cavityLevel_m(m, p) < 0.0);
        }
        EXPECT_LT(worst_m, 0.1 * kMm) << breath.v;
    }
}

TEST(Motion, JacobianIsTheDerivativeAndStaysPositiveAtThreefoldMotion) {
    Anywhere anywhere;
    for (const double scale : {1.0, 3.0}) {
        const MotionModel m = barrel(scale);
        constexpr double h = 1e-7;
        int compared = 0;
        for (const Surrogate& breath : kBreaths)
            for (int i = 0; i < 4000; ++i) {
                const Vec3 p = anywhere.point();
                const Mat3 j = motionJacobian(m, breath, p);
                ASSERT_GT(glm::determinant(j), 0.0);
                if (std::fabs(cavityLevel_m(m, p)) < 1e-6) continue;
                const Vec3 q = deformedFromReference(m, breath, p);
                double worst = 0.0;
                for (int axis = 0; axis < 3; ++axis) {
                    Vec3 step(0.0);
                    step[axis] = h;
                    const Vec3 slope = (deformedFromReference(m, breath, p + step) - q) / h;
                    worst = std::max(worst, glm::distance(slope, j[axis]));
                }
                compared += worst < 1e-5;  // except where the flow crosses a node's plane within h
            }
        EXPECT_GT(compared, 19900);
    }
}

TEST(Motion, VelocityIsTheTimeDerivative) {
    const MotionModel m = barrel();
    Anywhere anywhere;
    constexpr double h = 1e-5, kAcceleration = 2.0;
    const Surrogate now{0.4, 1.1}, soon{0.4 + 1.1 * h, 1.1 + kAcceleration * h};
    double fastest = 0.0;
    for (int i = 0; i < 5000; ++i) {
        const Vec3 p = anywhere.point();
        const Vec3 v = motionVelocity_m_s(m, now, kAcceleration, p);
        const Vec3 step = (deformedFromReference(m, soon, p) - deformedFromReference(m, now, p)) / h;
        ASSERT_LT(glm::distance(v, step), 1e-5);
        fastest = std::max(fastest, glm::distance(v, Vec3(0.0)));
    }
    EXPECT_GT(fastest, 0.012);
    EXPECT_EQ(motionVelocity_m_s(m, {9.0, 50.0}, 5.0, Vec3(0.0)), Vec3(0.0));  // both parts clamped
}

// Points move by 60 um per tick through the barrel while it breathes. The LocalMotion of each point is reused
// in the next tick.
TEST(Motion, FollowIsAccurateToMicrometres) {
    const MotionModel m = barrel();
    Anywhere anywhere;
    BreathingState breathing;
    int recomputed = 0, ticks = 0;
    double worst_m = 0.0, sum_m = 0.0;
    for (int point = 0; point < 40; ++point) {
        Vec3 p = anywhere.point();
        const Vec3 to = anywhere.point() - p;
        const Vec3 step = 60e-6 / std::sqrt(glm::dot(to, to)) * to;
        const Side side = cavityLevel_m(m, p) < 0.0 ? Side::inside : Side::outside;
        LocalMotion about;
        Vec3 known(-1.0);
        for (int tick = 0; tick < 1000; ++tick) {
            p += step;
            stepBreathing(breathing, {}, 0.001);
            const Surrogate now = surrogateAt(breathing, {}, 0.001);
            const double error_m =
                glm::distance(follow(about, m, now, side, p), deformedFromReference(m, now, side, p));
            worst_m = std::max(worst_m, error_m), sum_m += error_m;
            recomputed += about.reference_m != known;
            known = about.reference_m;
            ++ticks;
        }
    }
    EXPECT_LT(worst_m, 10e-6);
    EXPECT_LT(sum_m / ticks, 0.2e-6);
    EXPECT_GT(recomputed, 0.2 * ticks);
    EXPECT_LT(recomputed, 0.6 * ticks);  // two steps of 60 um exceed the reach
}

TEST(Motion, FollowRecomputesOutsideItsValidRange) {
    const MotionModel m = barrel();
    const Vec3 p(0.02, 0.01, 0.03);
    const Surrogate now{0.6, 0.4};
    LocalMotion about;
    const auto isRecomputed = [&](const Surrogate& breath, Side side, const Vec3& at) {
        LocalMotion then = about;
        const Vec3 found = follow(then, m, breath, side, at);
        const bool recomputed = then.reference_m != about.reference_m || then.v != about.v ||
                                then.rate_per_s != about.rate_per_s || then.side != about.side;
        const double error_m = glm::distance(found, deformedFromReference(m, breath, side, at));
        EXPECT_LT(error_m, recomputed ? 1e-15 : 1e-6);
        return recomputed;
    };
    EXPECT_TRUE(isRecomputed(now, Side::inside, p));
    follow(about, m, now, Side::inside, p);
    EXPECT_FALSE(isRecomputed(now, Side::inside, p));
    EXPECT_TRUE(isRecomputed(now, Side::outside, p));
    EXPECT_FALSE(isRecomputed(now, Side::inside, p + Vec3(0.0, 0.00009, 0.0)));
    EXPECT_TRUE(isRecomputed(now, Side::inside, p + Vec3(0.0, 0.00011, 0.0)));
    EXPECT_FALSE(isRecomputed({0.601, 0.4}, Side::inside, p));  // 15 um of breathing motion
    EXPECT_TRUE(isRecomputed({0.64, 0.4}, Side::inside, p));    // 0.6 mm of breathing motion
    const Mat3 j = motionJacobian(m, now, p), found = about.deformed_from_reference;
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LT(glm::distance(j[axis], found[axis]), 1e-15);
        EXPECT_LT(glm::distance(about.reference_from_deformed * found[axis], Mat3(1.0)[axis]), 1e-14);
    }
    EXPECT_LT(glm::distance(motionVelocity_m_s(m, now, 0.7, p), 0.4 * about.by_v_m + 0.7 * about.by_rate_m_s),
              1e-15);
    EXPECT_NEAR(about.level_m, cavityLevel_m(m, now, about.deformed_m), 0.1 * kMm);
}

TEST(Motion, SidesSlipAndLeaveNeitherGapNorOverlap) {
    const MotionModel m = barrel();
    for (const Surrogate& breath : kBreaths) {
        const InterfaceError error = measureInterface(m, breath);
        ASSERT_GT(error.points, 10000u);
        EXPECT_LT(error.worst_gap_m, 0.5 * kMm) << breath.v;
        EXPECT_LT(error.worst_overlap_m, 0.5 * kMm) << breath.v;
        EXPECT_LT(error.p99_m, 0.1 * kMm) << breath.v;
    }
    EXPECT_GT(measureInterface(m, kFull).max_slip_m, 14.0 * kMm);
    // Both sides move with the wall: its front is 5 mm farther out.
    const Vec3 in(0.0, 0.0795, 0.0), out(0.0, 0.0805, 0.0);
    EXPECT_NEAR(deformedFromReference(m, kFull, in).y - in.y, 5.0 * kMm, 0.3 * kMm);
    EXPECT_NEAR(deformedFromReference(m, kFull, out).y - out.y, 5.0 * kMm, 0.3 * kMm);
}

TEST(Motion, SideChangesAreFoundAlongAPath) {
    const MotionModel m = barrel();
    const Vec3 from(0.0, 0.16, 0.02), to(0.0, -0.16, 0.02);
    EXPECT_EQ(sideChanges(m, m.reference, from, to).count, 0);  // no relative slip
    const SideChanges changes = sideChanges(m, kFull, from, to);
    ASSERT_EQ(changes.count, 2);
    const double length_m = glm::distance(from, to);
    for (int i = 0; i < changes.count; ++i) {
        const SideChange& c = changes.list[std::size_t(i)];
        EXPECT_LE((c.after - c.before) * length_m, 1.001e-8);
        const double before = cavityLevel_m(m, kFull, from + c.before * (to - from));
        const double after = cavityLevel_m(m, kFull, from + c.after * (to - from));
        EXPECT_EQ(before < 0.0, i == 1);
        EXPECT_EQ(after < 0.0, i == 0);
        const Vec3 jump = referenceFromDeformed(m, kFull, from + c.after * (to - from)) -
                          referenceFromDeformed(m, kFull, from + c.before * (to - from));
        EXPECT_GT(std::fabs(jump.z), 14.0 * kMm);
    }
    std::vector<double> ends;
    forEachStretch(changes, [&](double begin, double end) { ends.push_back(begin), ends.push_back(end); });
    EXPECT_EQ(ends.size(), 6u);
    EXPECT_EQ(ends.front(), 0.0);
    EXPECT_EQ(ends.back(), 1.0);
    // A path of zero length, and a path that stays beside the surface.
    EXPECT_EQ(sideChanges(m, kFull, Vec3(0.0), Vec3(0.0)).count, 0);
    EXPECT_EQ(sideChanges(m, kFull, Vec3(0.0), Vec3(0.01)).count, 0);
}

// Where the sides overlap, a point stored together with its side maps back to its original position.
TEST(Motion, PointStoredWithItsSideMapsBack) {
    const MotionModel m = makeMotion(Vec3(0.1), 0.01, [](const Vec3& p) {
        MotionPoint q;
        q.level_m = p.x;
        q.slide_a1_m = Vec3(0.001, 0.0, -0.015) * smoothStep(0.09, 0.04, std::fabs(p.x)) *
                       smoothStep(0.09, 0.04, std::fabs(p.y)) * smoothStep(0.09, 0.04, std::fabs(p.z));
        return q;
    });
    const Vec3 inside(-0.0005, 0.0, 0.0);
    const Vec3 moved = deformedFromReference(m, kFull, Side::inside, inside);
    EXPECT_EQ(moved, deformedFromReference(m, kFull, inside));
    EXPECT_GT(moved.x, 0.0);  // across the surface
    EXPECT_EQ(sideAt(m, kFull, moved), Side::outside);
    EXPECT_EQ(referenceFromDeformed(m, kFull, moved), moved);
    EXPECT_LT(glm::distance(referenceFromDeformed(m, kFull, Side::inside, moved), inside), 0.001 * kMm);
    EXPECT_EQ(referenceFromDeformed(m, kFull, Side::outside, moved), moved);
    EXPECT_EQ(sideChanges(m, kFull, inside, moved).first, Side::inside);
    EXPECT_EQ(sideChanges(m, m.reference, moved, inside).first, Side::outside);
}

TEST(Motion, IsZeroOutsideTheGridAndWithoutNodes) {
    const MotionModel m = barrel();
    for (const Vec3& p :
         {Vec3(1e6, 0.0, 0.0), Vec3(-0.2, 0.1, 0.0), Vec3(0.0, 0.0, 1e300), Vec3(0.0, -3.0, 0.0)}) {
        EXPECT_EQ(deformedFromReference(m, kFull, p), p);
        EXPECT_EQ(referenceFromDeformed(m, kFull, p), p);
        EXPECT_EQ(motionJacobian(m, kFull, p), Mat3(1.0));
    }
    const MotionModel none;
    EXPECT_EQ(deformedFromReference(none, kFull, Vec3(0.1)), Vec3(0.1));
    EXPECT_EQ(motionVelocity_m_s(none, {0.5, 1.0}, 0.0, Vec3(0.1)), Vec3(0.0));
    EXPECT_GT(cavityLevel_m(none, Vec3(0.0)), 0.0);
    EXPECT_EQ(sideChanges(none, kFull, Vec3(0.0), Vec3(1.0)).count, 0);
}

// For any surrogate, jump and point, the result is finite, bounded and invertible.
TEST(Motion, AnySurrogateGivesFiniteInvertibleMotion) {
    const MotionModel m = barrel();
    Anywhere anywhere;
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = HUGE_VAL;
    const double wild[] = {nan, inf, -inf, 1e300, -1e300, 0.0, 0.7, -5.0, 40.0};
    for (const double v : wild)
        for (const double rate : wild) {
            const Surrogate breath{v, rate};
            for (int i = 0; i < 200; ++i) {
                const Vec3 p = anywhere.point();
                const Vec3 q = deformedFromReference(m, breath, p);
                ASSERT_LT(glm::distance(q, p), 40.0 * kMm);
                ASSERT_LT(glm::distance(motionVelocity_m_s(m, breath, 100.0, p), Vec3(0.0)), 1.0);
                ASSERT_GT(glm::determinant(motionJacobian(m, breath, p)), 0.0);
                if (std::fabs(cavityLevel_m(m, p)) < 1.0 * kMm) continue;
                ASSERT_LT(glm::distance(referenceFromDeformed(m, breath, q), p), 0.1 * kMm);
            }
        }
    // A non-finite point stays non-finite and causes no error.
    for (const Vec3& p : {Vec3(nan, 0.0, 0.0), Vec3(inf, -inf, 0.0)}) {
        EXPECT_FALSE(std::isfinite(deformedFromReference(m, kFull, p).x));
        sideChanges(m, kFull, p, Vec3(0.0));
        sideChanges(m, kFull, Vec3(0.0), p);
    }
}

// A constant level, a level on one side only, or one with steps gives no surface or a poor one. This must not
// cause errors.
TEST(Motion, HandlesDegenerateCavities) {
    for (const double level : {-0.5, 0.0, 0.5}) {
        MotionModel m = makeMotion(Vec3(0.05), 0.01, [&](const Vec3&) {
            MotionPoint q;
            q.slide_a1_m.z = 0.002;
            q.level_m = level;
            return q;
        });
        makeTangential(m);
        EXPECT_TRUE(cavitySurface(m).empty());
        EXPECT_EQ(measureInterface(m, kFull).points, 0u);
        EXPECT_NEAR(deformedFromReference(m, kFull, Vec3(0.0)).z, level < 0.0 ? 0.002 : 0.0, 1e-6);
        EXPECT_EQ(sideChanges(m, kFull, Vec3(-0.04), Vec3(0.04)).count, 0);
    }
    MotionModel chequered = makeMotion(Vec3(0.05), 0.01, [](const Vec3& p) {
        MotionPoint q;
        q.slide_a1_m.z = 0.002;
        q.level_m = (int(std::floor((p.x + p.y + p.z) * 100.0 + 0.5)) & 1) != 0 ? 0.004 : -0.004;
        return q;
    });
    makeTangential(chequered);
    Anywhere anywhere;
    for (int i = 0; i < 1000; ++i)
        ASSERT_LT(glm::distance(deformedFromReference(chequered, kFull, anywhere.point()), Vec3(0.0)), 1.0);
    EXPECT_LE(sideChanges(chequered, kFull, Vec3(-0.05, 0.001, 0.002), Vec3(0.05, 0.002, 0.001)).count,
              kMaxSideChanges);
}

TEST(MotionInterface, RaisedPointsLieOutside) {
    MotionModel m = barrel();
    const std::vector<Vec3> ribs = {{0.119, 0.0, 0.0}, {0.118, 0.01, 0.03}, {0.0, 0.079, 0.01}};
    for (const Vec3& p : ribs)
        ASSERT_LT(cavityLevel_m(m, p), 1.0 * kMm);
    raiseLevelAt(m, ribs, 1.0 * kMm);
    for (const Vec3& p : ribs)
        EXPECT_GE(cavityLevel_m(m, p), 0.999 * kMm);
    EXPECT_LT(cavityLevel_m(m, Vec3(0.1, 0.0, 0.0)), 0.0);
}

// Ribs protrude 3 mm into the barrel, 24 mm apart. The surface passes inside them and the sides can still
// slide.
TEST(MotionInterface, SurfacePassesRibsSmoothly) {
    MotionModel m = barrel();
    std::vector<Vec3> ribs;
    for (double z = -0.096; z <= 0.1; z += 0.024)
        for (int k = 0; k < 360; ++k) {
            const double phi = 0.0174533 * k;
            const double radius = std::sqrt(1.0 - 0.15 * (z / 0.15) * (z / 0.15) - 0.04);
            ribs.push_back({0.12 * radius * std::cos(phi), 0.08 * radius * std::sin(phi), z});
        }
    raiseLevelAt(m, ribs, 1.0 * kMm);
    makeTangential(m);
    for (const Vec3& p : ribs)
        ASSERT_GE(cavityLevel_m(m, p), 0.99 * kMm);
    const InterfaceError error = measureInterface(m, kFull);
    EXPECT_LT(error.worst_gap_m, 0.4 * kMm);
    EXPECT_LT(error.worst_overlap_m, 0.4 * kMm);
    EXPECT_GT(error.max_slip_m, 14.0 * kMm);
}

// One axis is compressed uniformly, so the Jacobian is exp(-0.3). Scaled by three, it is exp(-0.9).
TEST(MotionInterface, MinJacobianIsThatOfTheDeepestBreath) {
    MotionModel m = makeMotion(Vec3(0.12), 0.006, [](const Vec3& p) {
        MotionPoint q;
        const double near = smoothStep(0.11, 0.10, std::fabs(p.x)) * smoothStep(0.11, 0.10, std::fabs(p.y));
        q.slide_a1_m.z =
            near * std::clamp(-0.3 * p.z, -0.006, 0.006) * smoothStep(0.11, 0.04, std::fabs(p.z));
        return q;
    });
    m.v = {0.0, 1.0};
    EXPECT_NEAR(minJacobian(m, 1.0), std::exp(-0.3), 0.01);
    EXPECT_NEAR(minJacobian(m, 3.0), std::exp(-0.9), 0.01);
    m.v = {0.0, 0.5};
    EXPECT_NEAR(minJacobian(m, 1.0), std::exp(-0.15), 0.005);
}

}  // namespace
}  // namespace stylet::patient
