#include "haptics/tools/finger.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "base/statistics.h"
#include "patient/synth/synth.h"
#include "tests/haptics/along_x.h"
#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::haptics {
namespace {

using patient::Patient;
using patient::Surrogate;
using patient::Tissue;
using test::kAlongX;
using enum patient::Tissue;

// A patient and a finger that palpates it.
struct FingerBench {
    explicit FingerBench(const patient::Package& p, FingerSettings s = {})
        : package(p), settings(s), pad(fingerPad(s)) {}

    ToolForce at(const Pose& pose) {
        return stepFinger(state, settings, pad, {map, package.motion, breath}, pose);
    }
    ToolForce pressed(double depth_m, double z_m = 0.0) { return at({kAlongX, {depth_m, 0.0, z_m}}); }

    patient::Package package;
    Patient patient{package};
    TouchMap map = makeTouchMap(patient, makeSkin(patient, 2), 2);
    FingerSettings settings;
    Pad pad;
    FingerState state;
    Surrogate breath;
};

// A pad of exactly 2 cm^2, flat enough to touch with its whole area at once.
FingerSettings flatPad() {
    FingerSettings s;
    s.radius_m = std::sqrt(2e-4 / std::numbers::pi);
    s.curvature_m = 1e4;
    return s;
}

patient::Package uniform(std::vector<std::pair<Tissue, double>> slabs, double young_pa) {
    patient::Package p = test::makeSlabs(slabs, 0.001);
    for (patient::Elasticity& e : p.elasticity)
        if (std::isfinite(e.young_pa)) e.young_pa = young_pa;
    return p;
}

TEST(Finger, MatchesTheModelDocumentExample) {
    FingerBench rib(uniform({{soft, 0.008}, {bone, 0.010}}, 6000.0), flatPad());
    FingerBench gap(uniform({{soft, 0.060}}, 6000.0), flatPad());
    constexpr double kLight_m = 1e-5;
    EXPECT_NEAR(-rib.pressed(kLight_m).force_n.x / kLight_m, 150.0, 1.5);  // 0.15 N/mm
    EXPECT_NEAR(-gap.pressed(kLight_m).force_n.x / kLight_m, 30.0, 0.3);   // 0.03 N/mm
}

TEST(Finger, FeelsFlatLayersInClosedForm) {
    const patient::Package package =
        test::makeSlabs({{skin, 0.002}, {soft, 0.012}, {bone, 0.010}, {liver, 0.030}}, 0.001);
    FingerSettings settings = flatPad();
    settings.radius_m = std::sqrt(1e-4 / std::numbers::pi);
    FingerBench p(package, settings);
    const auto young = [&](Tissue t) { return package.elasticity[std::size_t(t)].young_pa; };
    const double cover_m = 0.014, k = 1e-4 / (0.002 / young(skin) + 0.012 / young(soft));
    for (const double depth_m : {0.0005, 0.002, 0.004, 0.0065}) {
        const double strain = depth_m / cover_m;
        const ToolForce f = p.pressed(depth_m);
        EXPECT_NEAR(-f.force_n.x / (k * depth_m * (1.0 - 0.5 * strain) / ((1.0 - strain) * (1.0 - strain))),
                    1.0, 1e-3);
        EXPECT_NEAR(f.energy_j / (0.5 * k * depth_m * depth_m / (1.0 - strain)), 1.0, 1e-3);
        EXPECT_LT(std::fabs(f.force_n.y) + std::fabs(f.force_n.z), 1e-4 * std::fabs(f.force_n.x));
        EXPECT_LT(glm::length(f.torque_n_m), 1e-4 * std::fabs(f.force_n.x));
    }
    // The finger cannot pass through bone, and the tangent stays below the pad's maximum stiffness.
    EXPECT_NEAR((p.pressed(0.0101).force_n.x - p.pressed(0.0100).force_n.x) / -1e-4,
                p.settings.pad.max_stiffness_n_per_m, 1.0);
}

TEST(Finger, MeetsABallAsTwoSpheresOnAnElasticFoundation) {
    // F = pi k R d^2 with 1/R = 1/R1 + 1/R2, in a map of an exact ball.
    constexpr double kBall_m = 0.060, kFoundation_n_per_m3 = 2.5e5, kDepth_m = 0.0012;
    constexpr int kNodes = 140;
    TouchMap ball{{Index3(kNodes), Vec3(0.001), Vec3(-0.001 * (0.5 * kNodes - 0.5))}, {}};
    forEachVoxel(ball.grid, [&](const Index3& i) {
        const auto level_m = float(glm::length(ball.grid.centre(i)) - kBall_m);
        ball.nodes.insert(ball.nodes.end(), {level_m, float(kFoundation_n_per_m3), 0.0f});
    });
    FingerSettings settings;
    settings.points = 30;
    settings.radius_m = 0.008;
    const Pad pad = fingerPad(settings);
    const double radius_m = 1.0 / (1.0 / settings.curvature_m + 1.0 / kBall_m);
    double sum_n = 0.0;
    constexpr int kDirections = 60;
    for (int i = 0; i < kDirections; ++i) {
        const double z = 1.0 - 2.0 * (i + 0.5) / kDirections, r = std::sqrt(1.0 - z * z);
        const Vec3 out{r * std::cos(2.4 * i), r * std::sin(2.4 * i), z};
        const Vec3 side = glm::normalize(glm::cross(Vec3(0.3, 0.5, -0.8), out));
        const Quat facing = glm::quat_cast(Mat3(side, glm::cross(out, side), out));
        FingerState fresh;
        const ToolForce f =
            stepFinger(fresh, settings, pad, {ball, {}, {}}, {facing, (kBall_m - kDepth_m) * out});
        sum_n += glm::dot(f.force_n, out);
    }
    EXPECT_NEAR(
        sum_n / kDirections / (std::numbers::pi * kFoundation_n_per_m3 * radius_m * kDepth_m * kDepth_m), 1.0,
        0.04);
}

TEST(Finger, TiltProducesRestoringTorque) {
    FingerSettings settings = flatPad();
    settings.points = 30;
    FingerBench p(uniform({{soft, 0.060}}, 20000.0), settings);
    constexpr double kTilt_rad = 0.05, kDepth_m = 0.002;
    const Quat tilted = glm::angleAxis(kTilt_rad, Vec3(0.0, 1.0, 0.0)) * kAlongX;
    const ToolForce f = p.at({tilted, {kDepth_m, 0.0, 0.0}});
    const double k = 2e-4 * 20000.0 / kTouchDepth_m;
    EXPECT_NEAR(-f.force_n.x / (k * kDepth_m), 1.0, 0.01);
    // Second moment of a disc about its diameter: A r^2 / 4.
    const double moment_n_m = k * kTilt_rad * settings.radius_m * settings.radius_m / 4.0;
    EXPECT_NEAR(f.torque_n_m.y / -moment_n_m, 1.0, 0.05);
    EXPECT_LT(std::fabs(f.torque_n_m.x) + std::fabs(f.torque_n_m.z), 0.05 * moment_n_m);
}

TEST(Finger, SticksThenSlips) {
    FingerBench p(uniform({{soft, 0.060}}, 20000.0), flatPad());
    const ToolForce pressed = p.pressed(0.004);
    const double normal_n = -pressed.force_n.x, shear = p.settings.pad.shear_n_per_m;
    const double most_n = p.settings.pad.friction * normal_n;
    for (int i = 1; i <= 100; ++i) {  // 10 mm along the skin
        const ToolForce f = p.pressed(0.004, 1e-4 * i);
        const double held_n = std::min(shear * 1e-4 * i, most_n);
        EXPECT_NEAR(-f.force_n.z, held_n, 1e-4);
        EXPECT_NEAR(f.energy_j - pressed.energy_j, 0.5 * held_n * held_n / shear, 1e-7);
    }
    // Reversal: the proxies stick at once, then slip in the other direction.
    EXPECT_NEAR(p.pressed(0.004, 0.010 - 1e-4).force_n.z, shear * 1e-4 - most_n, 1e-4);
    EXPECT_NEAR(p.pressed(0.004, 0.0).force_n.z, most_n, 1e-4);
    // After the finger lifts and presses again, no friction is left.
    EXPECT_EQ(glm::length(p.pressed(-0.002, 0.0).force_n), 0.0);
    EXPECT_NEAR(p.pressed(0.004, 0.0).force_n.z, 0.0, 1e-6);
}

TEST(Finger, FollowsBreathingMotion) {
    patient::Package package = uniform({{soft, 0.060}}, 20000.0);
    package.motion = test::makeShift(-0.010);
    const auto breathe = [](FingerBench& p, double v) { p.breath = {v, 0.0, 0.0}; };
    // The hand rests. The skin slides under it, drags it along, and slips.
    FingerBench still(package, flatPad());
    const double normal_n = -still.pressed(0.004).force_n.x;
    double moved_m = 0.0;
    ToolForce f;
    for (int i = 1; i <= 100; ++i) {
        breathe(still, 0.01 * i);
        f = still.pressed(0.004);
        EXPECT_NEAR(f.tissue_moved_m.z, -1e-4, 2e-6);
        moved_m += f.tissue_moved_m.z;
    }
    EXPECT_NEAR(moved_m, -0.010, 1e-4);
    EXPECT_NEAR(f.force_n.z / -(still.settings.pad.friction * normal_n), 1.0, 1e-3);
    EXPECT_NEAR(-f.force_n.x / normal_n, 1.0, 1e-3);
    // A hand that moves with the skin feels no friction.
    FingerBench along(package, flatPad());
    along.pressed(0.004);
    for (int i = 1; i <= 100; ++i) {
        breathe(along, 0.01 * i);
        f = along.pressed(0.004, -1e-4 * i);
    }
    EXPECT_LT(std::fabs(f.force_n.z), 0.01 * normal_n);
}

TEST(Finger, FeelsNothingInTheAir) {
    FingerBench p(uniform({{soft, 0.040}}, 20000.0));
    for (const double away_m : {0.0001, 0.005, 0.5}) {
        const ToolForce f = p.pressed(-away_m);
        EXPECT_EQ(f.force_n, Vec3(0.0));
        EXPECT_EQ(f.energy_j, 0.0);
    }
}

// A coarse model of the reference patient, touched by a wandering hand.
class Wandering : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        patient::synth::SynthSettings s;
        s.spacing_m = 0.0025;
        s.defaults = test::tissueDefaults();
        torso_ = new FingerBench(patient::synth::makeReferencePatient(s));
    }
    static void TearDownTestSuite() { delete torso_; }
    void SetUp() override { torso_->state = {}; }

    // Smooth paths into the flank, out of it, and along it.
    static Vec3 hand(double t_s) {
        return {0.148 + 0.012 * std::sin(2.1 * t_s), 0.03 * std::sin(0.37 * t_s),
                0.03 + 0.05 * std::sin(0.23 * t_s) + 0.01 * std::sin(3.3 * t_s)};
    }
    static Pose poseAt(double t_s) {
        return {glm::angleAxis(std::numbers::pi / 2.0, Vec3(0.0, 1.0, 0.0)), hand(t_s)};
    }

    static inline FingerBench* torso_ = nullptr;
};

TEST_F(Wandering, HandWorkEqualsStoredSpringEnergy) {
    patient::BreathingState breathing;
    const patient::BreathPlan plan{.rhythm = torso_->package.signal};
    double stored_j = 0.0, shortfall_j = 0.0, moved_j = 0.0, slipped_j = 0.0;
    Vec3 tip_m = hand(0.0);
    constexpr int kTicks = 20000;
    for (int i = 0; i < kTicks; ++i) {
        patient::stepBreathing(breathing, plan, 0.001);
        torso_->breath = patient::surrogateAt(breathing, plan, 0.001);
        const ToolForce f = torso_->at(poseAt(0.001 * i));
        const Vec3 now_m = hand(0.001 * i);
        const double put_in_j = -glm::dot(f.force_n, now_m - tip_m - f.tissue_moved_m);
        const double rest_j = put_in_j - (f.energy_j - stored_j);
        (rest_j < 0.0 ? shortfall_j : slipped_j) += std::fabs(rest_j);
        moved_j += std::fabs(put_in_j);
        stored_j = f.energy_j;
        tip_m = now_m;
    }
    EXPECT_GT(moved_j, 0.05);
    EXPECT_GT(slipped_j, 0.1 * moved_j);     // friction
    EXPECT_LT(shortfall_j, 0.01 * moved_j);  // error: the pad is rigid but the skin bends
    RecordProperty("moved_uj", int(1e6 * moved_j));
    RecordProperty("shortfall_uj", int(1e6 * shortfall_j));
    RecordProperty("slipped_uj", int(1e6 * slipped_j));
}

// Slides down the right flank at constant depth in the skin. Ribs must feel like bumps and the gaps must
// yield.
TEST_F(Wandering, FeelsRibsAsBumpsWhereItSlides) {
    constexpr double kDepth_m = 0.010, kStep_m = 2e-5;  // firm enough for ribs to stop a finger
    const patient::Skin skin = makeSkin(torso_->patient, 2);
    const auto overBone = [&](const Vec3& foot, const Vec3& inward) {
        for (double depth_m = 0.0; depth_m < kTouchDepth_m; depth_m += 0.0005)
            if (isSkeleton(torso_->patient.at(foot + depth_m * inward, {}).tissue)) return true;
        return false;
    };
    std::vector<double> force_n, mask, rib_n, gap_n;
    int edges = 0;
    for (const double y_m : {-0.02, 0.0, 0.02}) {
        torso_->state = {};
        Vec3 foot = nearestSkinPoint(skin, {0.148, y_m, 0.09});
        bool was = false;
        for (int i = 0; i < 6000; ++i) {
            foot = nearestSkinPoint(skin, foot - Vec3(0.0, 0.0, kStep_m));
            const Vec3 out = glm::normalize(skinAt(skin, foot).normal);
            const Vec3 side = glm::normalize(glm::cross(Vec3(0.0, 0.0, 1.0), out));
            const Pose pose{glm::quat_cast(patient::Mat3(side, glm::cross(out, side), out)),
                            foot - kDepth_m * out};
            const double normal_n = glm::dot(torso_->at(pose).force_n, out);
            const bool over = overBone(foot, -out);
            // Only centre positions, where the whole pad is over a rib or over a gap.
            const Vec3 pad(0.0, 0.0, torso_->settings.radius_m);
            const int parts = over + overBone(foot + pad, -out) + overBone(foot - pad, -out);
            if (parts == 3) rib_n.push_back(normal_n);
            if (parts == 0) gap_n.push_back(normal_n);
            force_n.push_back(normal_n), mask.push_back(over);
            edges += over != was;
            was = over;
        }
    }
    const double mean_force = mean(force_n), mean_mask = mean(mask);
    double both = 0.0, of_force = 0.0, of_mask = 0.0;
    for (std::size_t i = 0; i < mask.size(); ++i) {
        const double f = force_n[i] - mean_force, m = mask[i] - mean_mask;
        both += f * m, of_force += f * f, of_mask += m * m;
    }
    EXPECT_GT(edges, 20);
    EXPECT_GE(both / std::sqrt(of_force * of_mask), 0.7);
    EXPECT_GE(mean(rib_n) / mean(gap_n), 3.0);
    RecordProperty("pearson_permille", int(1e3 * both / std::sqrt(of_force * of_mask)));
    RecordProperty("rib_over_gap_permille", int(1e3 * mean(rib_n) / mean(gap_n)));
}

TEST_F(Wandering, HasABoundedTangent) {
    // Excludes the history of friction: proxies are reset at both ends.
    std::mt19937 random(3);
    const auto share = [&] { return double(random()) / 4294967296.0; };
    double along = 0.0, across = 0.0;
    constexpr double kStep_m = 1e-5;
    for (int i = 0; i < 4000; ++i) {
        const Pose pose = poseAt(100.0 * share());
        for (const Vec3& d : {Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0)}) {
            torso_->state = {};
            const Vec3 here_n = torso_->at(pose).force_n;
            torso_->state = {};
            const Vec3 there_n = torso_->at({pose.rotation, pose.position_m + kStep_m * d}).force_n;
            double& worst = d.x != 0.0 ? along : across;
            worst = std::max(worst, glm::length(there_n - here_n) / kStep_m);
        }
    }
    EXPECT_LT(along, torso_->settings.pad.max_stiffness_n_per_m);
    EXPECT_LT(across, torso_->settings.pad.max_stiffness_n_per_m);
    RecordProperty("along_n_per_m", int(along));
    RecordProperty("across_n_per_m", int(across));
}

TEST_F(Wandering, ForceIsFiniteForAnyPose) {
    for (const double x_m : {0.0, -0.2, 1e6, 9.99})
        for (const double z_m : {0.0, 5.0, -0.3}) {
            const ToolForce f = torso_->at({kAlongX, {x_m, 0.01, z_m}});
            EXPECT_TRUE(std::isfinite(glm::length(f.force_n) + glm::length(f.torque_n_m) + f.energy_j));
        }
}

}  // namespace
}  // namespace stylet::haptics
