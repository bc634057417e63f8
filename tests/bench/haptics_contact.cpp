// A finger on the reference patient. Measures the time per tick and the force error against the number of
// pad points.
#include <cmath>
#include <random>

#include <fmt/core.h>

#include "haptics/haptics.h"
#include "tests/bench/bench.h"
#include "tests/bench/reference_patient.h"

namespace stylet::bench {
namespace {

using namespace haptics;

constexpr int kSpots = 400;
constexpr int kMany = 300, kParts = 10;
constexpr double kDepth_m = 0.005;

// Poses of a finger that presses kDepth_m deep at random places on the right flank.
struct Flank {
    Flank() {
        std::mt19937 random(11);
        const auto share = [&] { return double(random()) / 4294967296.0; };
        while (int(poses.size()) < kSpots) {
            const Vec3 foot = nearestSkinPoint(skin, {0.14, 0.08 * share() - 0.04, 0.14 * share() - 0.03});
            const Vec3 out = glm::normalize(skinAt(skin, foot).normal);
            if (out.x < 0.5) continue;
            const Vec3 side = glm::normalize(glm::cross(Vec3(0.0, 0.0, 1.0), out));
            poses.push_back({glm::quat_cast(Mat3(side, glm::cross(out, side), out)), foot - kDepth_m * out});
        }
    }
    const patient::Package package = referencePatient(0.0015);
    const patient::Patient patient{package};
    const patient::Skin skin = makeSkin(patient, 2);
    const TouchMap map = makeTouchMap(patient, skin, 2);
    std::vector<Pose> poses;
};

// Reference force of a pad with kMany points. The pad is split into kParts parts, because one FingerState
// cannot store so many points.
Vec3 reference(const Flank& flank, const FingerSettings& settings, const Pose& pose) {
    static const std::vector<Pad> parts = [&] {
        std::vector<Pad> list(kParts);
        const double area_m2 = 3.14159265358979323846 * settings.radius_m * settings.radius_m;
        for (int i = 0; i < kMany; ++i) {
            Pad& pad = list[std::size_t(i % kParts)];
            const double r_m = settings.radius_m * std::sqrt((i + 0.5) / kMany),
                         angle = 2.39996322972865332 * i;
            const double up_m =
                settings.curvature_m - std::sqrt(settings.curvature_m * settings.curvature_m - r_m * r_m);
            pad.points_m[std::size_t(pad.count++)] = {r_m * std::cos(angle), r_m * std::sin(angle), up_m};
            pad.point_area_m2 = area_m2 / kMany;
            pad.reach_m = settings.radius_m;
        }
        return list;
    }();
    FingerSettings part = settings;
    part.pad.max_stiffness_n_per_m /= kParts, part.pad.shear_n_per_m /= kParts;
    Vec3 sum(0.0);
    for (const Pad& pad : parts) {
        FingerState state;
        sum += stepFinger(state, part, pad, {flank.map, flank.package.motion, {}}, pose).force_n;
    }
    return sum;
}

double median_us(const Flank& flank, const FingerSettings& settings, const Pad& pad) {
    std::vector<double> times_us;
    FingerState state;
    patient::Surrogate breath;
    for (int round = 0; round < 10; ++round)
        for (const Pose& pose : flank.poses) {
            breath.v = 0.5 + 0.4 * std::sin(0.01 * double(times_us.size()));
            const auto began = std::chrono::steady_clock::now();
            stepFinger(state, settings, pad, {flank.map, flank.package.motion, breath}, pose);
            times_us.push_back(1e3 * elapsed_ms(began));
        }
    return median(times_us);
}

double lookUp_ns(const Flank& flank) {
    double level_m = 0.0;
    const double time_ms = medianTime_ms(100, [&] {
        for (const Pose& pose : flank.poses)
            level_m += skinAt(flank.skin, pose.position_m).level_m;
    });
    return level_m < 0.0 ? 1e6 * time_ms / kSpots : 0.0;
}

void run(std::vector<Row>& rows) {
    const Flank flank;
    for (const int points : {7, 13, 19, 25, 30}) {
        FingerSettings settings;
        settings.points = points;
        const Pad pad = fingerPad(settings);
        std::vector<double> errors;
        double force_n = 0.0;
        for (const Pose& pose : flank.poses) {
            FingerState state;
            const Vec3 coarse =
                stepFinger(state, settings, pad, {flank.map, flank.package.motion, {}}, pose).force_n;
            const Vec3 fine = reference(flank, settings, pose);
            errors.push_back(glm::length(coarse - fine));
            force_n += glm::length(fine) / kSpots;
        }
        const double tick_us = median_us(flank, settings, pad);
        const std::string note = fmt::format(
            "median {:.2f} us a breathing tick; {:.3f} N mean force 5 mm deep; skin look-up {:.0f} ns",
            tick_us, force_n, lookUp_ns(flank));
        rows.push_back({"haptics.contact", "points of the pad", double(points), 1e-3 * tick_us,
                        quantile(errors, 0.99), "N p99", "300 points", note});
    }
}

const Registration registration("haptics.contact", run);

}  // namespace
}  // namespace stylet::bench
