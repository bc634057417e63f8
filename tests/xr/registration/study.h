// Registers simulated devices whose true pose is known. Shows the effect of noise, few points, offsets,
// latency and outliers. Used by the tests and by `stylet-bench --only xr.registration`.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "xr/registration/registration.h"

namespace stylet::xr::registration::study {

enum class Method {
    plain,   // Umeyama's fit of points, with no other unknowns
    held,    // the wizard's fit of points with the device at rest, tip known from a pivot
    motion,  // the wizard's fit of twenty seconds of motion
};

struct Case {
    Method method = Method::plain;
    int points = 8;              // unused for motion
    double noise_m = 0.001;      // sd along an axis, of a point used by the fit or of a motion sample
    bool random_places = false;  // drawn from the cube; otherwise chooseTouchPlaces()
    // Difficulties.
    double gimbal_m = 0.0, scale_error = 0.0, delay_s = 0.0, outliers = 0.0;
    double correlation_time_s = 0.0;  // motion: correlation time of the noise
};

struct Errors {
    std::vector<double> tre_m;  // errors of all trials, at `targets` places each in the cube
    double rms_m = 0.0, mean_m = 0.0, p999_m = 0.0;
    double expected_rms_m = 0.0;  // plain: Fitzpatrick's formula; otherwise the fit's own prediction
    double fre_m = 0.0, expected_fre_m = 0.0;
    double accepted = 0.0;  // share of the trials
    double mean_accepted_m = 0.0, p999_accepted_m = 0.0;
    double delay_error_s = 0.0, scale_error = 0.0, gimbal_error_m = 0.0;  // rms of the remaining errors
    double fit_ms = 0.0;                                                  // median
    int trials = 0, refused = 0;
};

Errors run(const Case&, int trials, std::uint64_t seed, int targets = 8);

// True values of one simulated registration.
struct Truth {
    Pose stage_from_device;
    double scale = 1.0, delay_s = 0.0;
    Vec3 stylus_from_tip_m{0.0}, grip_from_tip_m{0.0};
    Vec3 inStage(const Pose& device_from_stylus) const {
        return stage_from_device * (scale * (device_from_stylus * stylus_from_tip_m));
    }
};
class Random {
  public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}
    double normal() { return normal_(engine_); }
    double share() { return std::uniform_real_distribution<double>(0.0, 1.0)(engine_); }
    double between(double a, double b) { return a + (b - a) * share(); }
    Vec3 normal3() { return {normal(), normal(), normal()}; }
    Vec3 inCube(double half) { return {between(-half, half), between(-half, half), between(-half, half)}; }
    Vec3 direction() { return glm::normalize(normal3() + Vec3(1e-12)); }
    Quat turn(double max_rad) { return glm::angleAxis(between(-max_rad, max_rad), direction()); }

  private:
    std::mt19937_64 engine_;
    std::normal_distribution<double> normal_;
};
Truth makeTruth(const Case&, Random&);
struct Streams {
    std::vector<TimedPose> device, tracked;
};
Streams makeMotion(const Case&, const Truth&, Random&, double seconds = 20.0);
std::vector<Pair> makePoints(const Case&, const Truth&, Random&);

}  // namespace stylet::xr::registration::study
