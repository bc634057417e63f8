#include "tests/xr/registration/study.h"

#include <algorithm>
#include <chrono>

#include "base/statistics.h"

namespace stylet::xr::registration::study {
namespace {

constexpr double kTurn_rad = 0.6;           // largest rotation of a wrist to either side
constexpr double kTipError_m = 0.0004;      // error of the earlier pivot, along an axis
constexpr double kWander_m_per_s = 0.005;   // motion of a hand that tries to hold still
constexpr double kDeviceNoise_m = 0.00003;  // noise of the encoders
constexpr double kMinOutlier_m = 0.01, kMaxOutlier_m = 0.06;
constexpr double kBurst_s = 0.1;  // duration of a tracker jump
constexpr double kTwoPi = 6.283185307179586;

Vec3 outlierOffset(Random& random) {
    return random.between(kMinOutlier_m, kMaxOutlier_m) * random.direction();
}

// One axis of a hand's motion through the cube: the sum of three sine waves.
struct Wave {
    explicit Wave(Random& random, double size) {
        for (std::size_t i = 0; i < 3; ++i) {
            frequency_hz[i] = random.between(0.1, 0.45);
            phase[i] = random.between(0.0, kTwoPi);
            amplitude[i] = size * random.between(0.35, 0.7);
        }
    }
    double at(double t_s) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < 3; ++i)
            sum += amplitude[i] * std::sin(kTwoPi * frequency_hz[i] * t_s + phase[i]);
        return sum;
    }
    std::array<double, 3> frequency_hz{}, phase{}, amplitude{};
};
struct Wander {
    explicit Wander(Random& random, double size)
        : axes{Wave(random, size), Wave(random, size), Wave(random, size)} {}
    Vec3 at(double t_s) const { return {axes[0].at(t_s), axes[1].at(t_s), axes[2].at(t_s)}; }
    std::array<Wave, 3> axes;
};

Quat rotationFromVector(const Vec3& by) {
    const double angle = glm::length(by);
    return angle > 0.0 ? glm::angleAxis(angle, by / angle) : Quat(1.0, 0.0, 0.0, 0.0);
}

// Pose of the controller whose tip touches the device's tip.
Pose makeGrip(const Truth& truth, const Pose& device_from_stylus, const Quat& turn) {
    return {turn, truth.inStage(device_from_stylus) - turn * truth.grip_from_tip_m};
}

FitSettings makeSettings(const Truth& truth, Random& random) {
    FitSettings s;
    s.tip = true;
    s.tip_guess_m = truth.grip_from_tip_m + kTipError_m * random.normal3();
    s.tip_sd_m = kTipError_m;
    return s;
}

Result<Fit> fitPlain(const std::vector<Pair>& pairs, const Truth& truth) {
    std::vector<Vec3> stage, device;
    for (const Pair& pair : pairs) {
        stage.push_back(pair.stage_from_grip * truth.grip_from_tip_m);
        device.push_back(pair.device_from_stylus.position_m);
    }
    const Result<RigidFit> rigid = fitRigid(stage, device, false);
    if (!rigid) return failure<Fit>(rigid.why_not);
    Fit fit;
    fit.stage_from_device = rigid->a_from_b;
    fit.fre_m = rigid->fre_m;
    return {fit, ""};
}

double meanOrZero(const std::vector<double>& values) {
    return values.empty() ? 0.0 : mean(values);
}

}  // namespace

Truth makeTruth(const Case& c, Random& random) {
    Truth truth;
    truth.stage_from_device = {glm::angleAxis(random.between(0.0, kTwoPi), random.direction()),
                               Vec3(0.0, 1.0, -0.5) + random.inCube(0.5)};
    truth.scale = 1.0 + c.scale_error;
    truth.delay_s = c.delay_s;
    truth.stylus_from_tip_m = c.gimbal_m * random.direction();
    truth.grip_from_tip_m = Vec3(0.0, -0.03, -0.1) + random.inCube(0.03);
    return truth;
}

std::vector<Pair> makePoints(const Case& c, const Truth& truth, Random& random) {
    std::vector<Vec3> places = chooseTouchPlaces(Cube{}, c.points);
    const bool turns = c.method != Method::plain;
    std::vector<Pair> pairs;
    for (const Vec3& place : places) {
        const Vec3 at = c.random_places ? random.inCube(0.04) : place;
        const Pose device{turns ? random.turn(kTurn_rad) : Quat(1.0, 0.0, 0.0, 0.0), at};
        Pose grip = makeGrip(truth, device, turns ? random.turn(kTurn_rad) : Quat(1.0, 0.0, 0.0, 0.0));
        grip.position_m += c.noise_m * random.normal3();
        if (turns) grip.position_m -= c.delay_s * kWander_m_per_s * random.normal3();
        if (random.share() < c.outliers) grip.position_m += outlierOffset(random);
        pairs.push_back({device, grip, Vec3(0.0)});
    }
    return pairs;
}

Streams makeMotion(const Case& c, const Truth& truth, Random& random, double seconds) {
    const Wander path(random, 0.028), device_turn(random, 0.35), grip_turn(random, 0.35);
    const auto deviceAt = [&](double t_s) {
        return Pose{rotationFromVector(device_turn.at(t_s)), path.at(t_s)};
    };
    Streams streams;
    for (double t_s = 0.0; t_s < seconds; t_s += 0.004) {
        Pose device = deviceAt(t_s);
        device.position_m += kDeviceNoise_m * random.normal3();
        streams.device.push_back({t_s, device});
    }
    constexpr double kFrame_s = 1.0 / 90.0;
    const double kept = c.correlation_time_s > 0.0 ? std::exp(-kFrame_s / c.correlation_time_s) : 0.0;
    Vec3 noise = random.normal3(), off(0.0);
    double wrong_until_s = -1.0;
    for (double t_s = 0.3; t_s < seconds; t_s += kFrame_s) {
        const double shown_s = t_s - truth.delay_s;
        Pose grip = makeGrip(truth, deviceAt(shown_s), rotationFromVector(grip_turn.at(shown_s)));
        noise = kept * noise + std::sqrt(1.0 - kept * kept) * random.normal3();
        grip.position_m += c.noise_m * noise;
        if (t_s >= wrong_until_s) off = Vec3(0.0);
        // The probability of a burst gives the required share of wrong samples.
        if (t_s >= wrong_until_s && random.share() < c.outliers / (1.0 - c.outliers) * kFrame_s / kBurst_s)
            off = outlierOffset(random), wrong_until_s = t_s + kBurst_s;
        grip.position_m += off;
        streams.tracked.push_back({t_s, grip});
    }
    return streams;
}

Errors run(const Case& c, int trials, std::uint64_t seed, int targets) {
    Errors errors;
    errors.trials = trials;
    std::vector<double> accepted_m, times_ms;
    double squares = 0.0, expected = 0.0, fre = 0.0, late = 0.0, scale = 0.0, gimbal = 0.0;
    for (int trial = 0; trial < trials; ++trial) {
        Random random(seed * 1'000'003 + std::uint64_t(trial));
        const Truth truth = makeTruth(c, random);
        const FitSettings settings = makeSettings(truth, random);
        Streams streams;
        std::vector<Pair> pairs;
        if (c.method == Method::motion)
            streams = makeMotion(c, truth, random);
        else
            pairs = makePoints(c, truth, random);
        const auto began = std::chrono::steady_clock::now();
        const Result<Fit> fit = c.method == Method::plain ? fitPlain(pairs, truth)
                                : c.method == Method::motion
                                    ? fitMotion(streams.device, streams.tracked, settings)
                                    : fitPairs(pairs, settings);
        times_ms.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - began).count());
        if (!fit) {
            ++errors.refused;
            continue;
        }
        const bool accept = c.method == Method::plain || evaluateFit(*fit).accept;
        errors.accepted += accept ? 1.0 / trials : 0.0;
        std::vector<Vec3> points;
        for (const Pair& pair : pairs)
            points.push_back(pair.device_from_stylus.position_m);
        for (int i = 0; i < targets; ++i) {
            const bool turns = c.method != Method::plain;
            const Pose target{turns ? random.turn(kTurn_rad) : Quat(1.0, 0.0, 0.0, 0.0), random.inCube(0.04)};
            const double tre_m = glm::distance(fit->inStage(target), truth.inStage(target));
            errors.tre_m.push_back(tre_m);
            squares += tre_m * tre_m;
            if (accept) accepted_m.push_back(tre_m);
            const double wanted_m = c.method == Method::plain
                                        ? expectedTre_m(points, std::sqrt(3.0) * c.noise_m, target.position_m)
                                        : fit->tre.mean_m;
            expected += wanted_m * wanted_m;
        }
        fre += fit->fre_m * fit->fre_m;
        late += std::pow(fit->latency_s - truth.delay_s, 2);
        scale += std::pow(fit->scale - truth.scale, 2);
        const Vec3 off = fit->stylus_from_tip_m - truth.stylus_from_tip_m;
        gimbal += glm::dot(off, off);
    }
    const double fitted = std::max(1, trials - errors.refused);
    errors.rms_m = std::sqrt(squares / double(std::max<std::size_t>(1, errors.tre_m.size())));
    errors.expected_rms_m = std::sqrt(expected / double(std::max<std::size_t>(1, errors.tre_m.size())));
    errors.mean_m = meanOrZero(errors.tre_m), errors.p999_m = lowerQuantile(errors.tre_m, 0.999);
    errors.mean_accepted_m = meanOrZero(accepted_m),
    errors.p999_accepted_m = lowerQuantile(accepted_m, 0.999);
    errors.fre_m = std::sqrt(fre / fitted);
    errors.expected_fre_m = expectedFre_m(c.points, std::sqrt(3.0) * c.noise_m);
    errors.delay_error_s = std::sqrt(late / fitted), errors.scale_error = std::sqrt(scale / fitted);
    errors.gimbal_error_m = std::sqrt(gimbal / fitted);
    errors.fit_ms = lowerQuantile(times_ms, 0.5);
    return errors;
}

}  // namespace stylet::xr::registration::study
