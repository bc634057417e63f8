#include "xr/registration/fit.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <random>

#include "base/statistics.h"
#include "xr/registration/eigen.h"

namespace stylet::xr::registration {
namespace {

// Indices of the unknowns: rotation and translation of stage_from_device, then the optional ones.
constexpr int kRotation = 0, kTranslation = 3, kScale = 6, kGimbal = 7, kTip = 10, kLatency = 13,
              kUnknowns = 14;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Rows = Eigen::Matrix<double, 3, kUnknowns>;

constexpr double kMinThickness_m = 0.004;  // RMS thickness of a point set; thinner counts as a plane
constexpr double kMinDistance_m = 0.003;   // closer points count as one
constexpr int kMaxDraws = 400, kSubset = 3, kSubsetForTip = 8;
constexpr std::size_t kMaxMedianPairs = 150;  // limit of the pairs that rate a subset
constexpr double kMedianToSd = 1.0 / 1.538;   // the median length of a 3D normal error is 1.538 sd
constexpr double kPairOutlier = 3.6;          // in standard deviations: 0.5 % of good pairs exceed it
constexpr double kMinIndependent = 8.0;
constexpr double kMinPairNoise_m = 5e-5;  // lower bound of the noise estimate
constexpr int kFitRounds = 12, kSteps = 4;
constexpr double kFixed = 1e12;  // weight (1/m^2 etc.) of an unknown that is not estimated

Eigen::Matrix3d cross(const Vec3& v) {
    Eigen::Matrix3d m;
    m << 0, -v.z, v.y, v.z, 0, -v.x, -v.y, v.x, 0;
    return m;
}

Vec3 residual(const Fit& fit, const Pair& pair) {
    const Vec3 tip_m = pair.device_from_stylus * fit.stylus_from_tip_m - fit.latency_s * pair.tip_m_per_s;
    return fit.stage_from_device * (fit.scale * tip_m) - pair.stage_from_grip * fit.grip_from_tip_m;
}

// Derivative of the device tip's position in the stage by each unknown. The rotation is about the device's
// origin, in the axes of the stage.
Rows targetJacobian(const Fit& fit, const Pose& device_from_stylus, const Vec3& tip_m_per_s) {
    const Vec3 tip_m = device_from_stylus * fit.stylus_from_tip_m - fit.latency_s * tip_m_per_s;
    const Quat& turn = fit.stage_from_device.rotation;
    Rows rows = Rows::Zero();
    rows.middleCols<3>(kRotation) = -cross(turn * (fit.scale * tip_m));
    rows.middleCols<3>(kTranslation).setIdentity();
    rows.col(kScale) = eigen(turn * tip_m);
    rows.middleCols<3>(kGimbal) = fit.scale * toMatrix(turn * device_from_stylus.rotation);
    rows.col(kLatency) = -eigen(turn * (fit.scale * tip_m_per_s));
    return rows;
}

Rows residualJacobian(const Fit& fit, const Pair& pair) {
    Rows rows = targetJacobian(fit, pair.device_from_stylus, pair.tip_m_per_s);
    rows.middleCols<3>(kTip) = -toMatrix(pair.stage_from_grip.rotation);
    return rows;
}

Vector priorWeights(const FitSettings& s) {
    Vector weights = Vector::Zero();
    const auto set = [&](int at, int count, bool on, double sd) {
        weights.segment(at, count).setConstant(on ? 1.0 / (sd * sd) : kFixed);
    };
    set(kScale, 1, s.scale, s.scale_sd);
    set(kGimbal, 3, s.gimbal, s.gimbal_sd_m);
    set(kTip, 3, s.tip, s.tip_sd_m);
    set(kLatency, 1, s.latency, s.latency_sd_s);
    return weights;
}

// Difference of the unknowns from their prior means.
Vector fromPrior(const Fit& fit, const FitSettings& s) {
    Vector off = Vector::Zero();
    off[kScale] = fit.scale - 1.0;
    off.segment<3>(kGimbal) = eigen(fit.stylus_from_tip_m);
    off.segment<3>(kTip) = eigen(fit.grip_from_tip_m - s.tip_guess_m);
    off[kLatency] = fit.latency_s;
    return off;
}

void applyStep(Fit& fit, const Vector& by) {
    const Vec3 turn(by[kRotation], by[kRotation + 1], by[kRotation + 2]);
    const double angle = glm::length(turn);
    const Quat q = angle > 0.0 ? glm::angleAxis(angle, turn / angle) : Quat(1.0, 0.0, 0.0, 0.0);
    fit.stage_from_device.rotation = glm::normalize(q * fit.stage_from_device.rotation);
    fit.stage_from_device.position_m += Vec3(by[kTranslation], by[kTranslation + 1], by[kTranslation + 2]);
    fit.scale += by[kScale];
    fit.stylus_from_tip_m += Vec3(by[kGimbal], by[kGimbal + 1], by[kGimbal + 2]);
    fit.grip_from_tip_m += Vec3(by[kTip], by[kTip + 1], by[kTip + 2]);
    fit.latency_s += by[kLatency];
}

// Normal equations of the used pairs and the priors.
struct NormalEquations {
    Matrix matrix;
    Vector right;
};
NormalEquations makeNormalEquations(const Fit& fit, std::span<const Pair> pairs,
                                    const FitSettings& settings) {
    const Vector prior = priorWeights(settings);
    const double weight = fit.effective_pairs / (fit.inliers * fit.noise_m * fit.noise_m);
    NormalEquations normal{prior.asDiagonal(), -prior.cwiseProduct(fromPrior(fit, settings))};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (!fit.used[i]) continue;
        const Rows rows = residualJacobian(fit, pairs[i]);
        normal.matrix.noalias() += weight * (rows.transpose() * rows);
        normal.right.noalias() -= weight * (rows.transpose() * eigen(residual(fit, pairs[i])));
    }
    return normal;
}

// Number of consecutive pairs that carry as much information as one independent pair: 1 + 2 * the sum of
// the residuals' autocorrelation, up to the first lag at which it is below 0.05.
double correlationFactor(const Fit& fit, std::span<const Pair> pairs) {
    std::vector<Vec3> off;
    for (std::size_t i = 0; i < pairs.size(); ++i)
        if (fit.used[i]) off.push_back(residual(fit, pairs[i]));
    double power = 0.0;
    for (const Vec3& r : off)
        power += glm::dot(r, r);
    double share = 1.0;
    for (std::size_t lag = 1; power > 0.0 && lag < off.size() / 4; ++lag) {
        double product = 0.0;
        for (std::size_t i = lag; i < off.size(); ++i)
            product += glm::dot(off[i], off[i - lag]);
        if (product < 0.05 * power) break;
        share += 2.0 * product / power;
    }
    return share;
}

// Estimates the noise per axis from the residuals and the expected noise, and the effective number of
// independent pairs.
void measureNoise(Fit& fit, std::span<const Pair> pairs, const FitSettings& settings, double unknowns) {
    double squares = 0.0;
    fit.inliers = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (!fit.used[i]) continue;
        const Vec3 off = residual(fit, pairs[i]);
        squares += glm::dot(off, off);
        ++fit.inliers;
    }
    fit.rejected = int(pairs.size()) - fit.inliers;
    fit.fre_m = std::sqrt(squares / fit.inliers);
    fit.effective_pairs = fit.inliers;
    if (settings.in_order)
        fit.effective_pairs = std::max(kMinIndependent, fit.inliers / correlationFactor(fit, pairs));
    // The fitted unknowns use up degrees of freedom of the independent pairs.
    const double left = std::max(0.0, 1.0 - unknowns / (3.0 * fit.effective_pairs));
    const double freedom = 3.0 * fit.inliers * left, expected = 3.0 * settings.noise_pairs;
    const double variance = (squares + expected * settings.noise_m * settings.noise_m) / (freedom + expected);
    fit.noise_m = std::max(kMinPairNoise_m, std::sqrt(variance));
}

// Effective number of unknowns determined by the pairs. Each counts by the share of its information that
// comes from the pairs and not from its prior.
double countDetermined(const Fit& fit, std::span<const Pair> pairs, const FitSettings& settings) {
    const NormalEquations normal = makeNormalEquations(fit, pairs, settings);
    const Matrix left = normal.matrix.ldlt().solve(Matrix(priorWeights(settings).asDiagonal()));
    return kUnknowns - left.trace();
}

std::vector<Vec3> gripTips(std::span<const Pair> pairs, const Vec3& grip_from_tip_m) {
    std::vector<Vec3> tips;
    for (const Pair& pair : pairs)
        tips.push_back(pair.stage_from_grip * grip_from_tip_m);
    return tips;
}

// With an unknown tip: solves linearly for an affine map, a translation and the tip. The tip then turns the
// controller poses into points for a rigid fit.
Result<RigidFit> fitSubsetWithTip(std::span<const Pair> drawn, const Vec3& guess_m, Vec3& tip_m) {
    using Unknowns = Eigen::Matrix<double, 15, 1>;
    Eigen::Matrix<double, 15, 15> normal = Eigen::Matrix<double, 15, 15>::Identity() * 1e-9;
    // A very weak prior at the guess determines the tip if nothing was rotated.
    Unknowns right = Unknowns::Zero();
    right.tail<3>() = 1e-9 * eigen(guess_m);
    for (const Pair& pair : drawn) {
        Eigen::Matrix<double, 3, 15> row = Eigen::Matrix<double, 3, 15>::Zero();
        for (int axis = 0; axis < 3; ++axis) {
            row.block<1, 3>(axis, 3 * axis) = eigen(pair.device_from_stylus.position_m).transpose();
            row(axis, 9 + axis) = 1.0;
        }
        row.rightCols<3>() = -toMatrix(pair.stage_from_grip.rotation);
        normal += row.transpose() * row;
        right += row.transpose() * eigen(pair.stage_from_grip.position_m);
    }
    const Unknowns solved = normal.ldlt().solve(right);
    tip_m = {solved[12], solved[13], solved[14]};
    if (!isFinite(tip_m)) return failure<RigidFit>("The drawn pairs do not determine the tip.");
    return fitRigid(gripTips(drawn, tip_m), deviceTips(drawn), false);
}

double medianResidual_m(const Fit& fit, std::span<const Pair> pairs) {
    std::vector<double> lengths;
    const std::size_t step = std::max<std::size_t>(1, pairs.size() / kMaxMedianPairs);
    for (std::size_t i = 0; i < pairs.size(); i += step)
        lengths.push_back(glm::length(residual(fit, pairs[i])));
    return upperMedian(std::move(lengths));
}

// Calls `visit` with subsets of the indices: with all subsets if there are few, otherwise with random ones.
template <typename Visit>
void drawSubsets(std::size_t pairs, std::size_t size, std::uint32_t seed, const Visit& visit) {
    std::vector<std::size_t> chosen(size);
    if (size == kSubset && pairs * (pairs - 1) * (pairs - 2) / 6 <= std::size_t(kMaxDraws)) {
        for (chosen[0] = 0; chosen[0] < pairs; ++chosen[0])
            for (chosen[1] = chosen[0] + 1; chosen[1] < pairs; ++chosen[1])
                for (chosen[2] = chosen[1] + 1; chosen[2] < pairs; ++chosen[2])
                    visit(chosen);
        return;
    }
    std::mt19937 random(seed);
    for (int draw = 0; draw < kMaxDraws; ++draw) {
        for (std::size_t i = 0; i < size; ++i) {
            do
                chosen[i] = random() % pairs;
            while (std::find(chosen.begin(), chosen.begin() + std::ptrdiff_t(i), chosen[i]) !=
                   chosen.begin() + std::ptrdiff_t(i));
        }
        visit(chosen);
    }
}

bool isTipVague(const FitSettings& settings) {
    return settings.tip && settings.tip_sd_m >= kVague_m;
}

// Least median of squares over small subsets.
Result<Fit> consensus(std::span<const Pair> pairs, const FitSettings& settings) {
    const std::size_t size = isTipVague(settings) ? kSubsetForTip : kSubset;
    Fit best;
    double best_m = std::numeric_limits<double>::infinity();
    std::vector<Pair> drawn(size);
    drawSubsets(pairs.size(), size, settings.seed, [&](const std::vector<std::size_t>& chosen) {
        for (std::size_t i = 0; i < size; ++i)
            drawn[i] = pairs[chosen[i]];
        Fit fit;
        fit.grip_from_tip_m = settings.tip_guess_m;
        const Result<RigidFit> rigid =
            isTipVague(settings) ? fitSubsetWithTip(drawn, settings.tip_guess_m, fit.grip_from_tip_m)
                                 : fitRigid(gripTips(drawn, settings.tip_guess_m), deviceTips(drawn), false);
        if (!rigid) return;
        fit.stage_from_device = rigid->a_from_b;
        const double median_m = medianResidual_m(fit, pairs);
        if (median_m < best_m) best = fit, best_m = median_m;
    });
    if (!std::isfinite(best_m)) return failure<Fit>("No three points lie well apart from one line.");
    best.noise_m = std::max({best_m * kMedianToSd, settings.noise_m, kMinPairNoise_m});
    return {best, ""};
}

bool selectInliers(Fit& fit, std::span<const Pair> pairs, double noise_m) {
    std::vector<bool> used(pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i)
        used[i] = glm::length(residual(fit, pairs[i])) <= kPairOutlier * noise_m;
    const bool same = used == fit.used;
    fit.used = std::move(used);
    fit.inliers = int(std::count(fit.used.begin(), fit.used.end(), true));
    return same;
}

// Predicts the error in the cube by propagating the unknowns' covariance to target points, for the stylus
// orientations of the used pairs.
void predictErrors(Fit& fit, std::span<const Pair> pairs, const FitSettings& settings) {
    const Matrix covariance =
        makeNormalEquations(fit, pairs, settings).matrix.ldlt().solve(Matrix::Identity());
    constexpr int kMaxOrientations = 32;
    // Gauss-Legendre quadrature with two nodes per axis: exact for squares.
    const double inner_m = settings.cube.half_m / std::sqrt(3.0);
    double mean = 0.0, worst = 0.0;
    int orientations = 0;
    const std::size_t step = std::max<std::size_t>(1, pairs.size() / kMaxOrientations);
    for (std::size_t i = 0; i < pairs.size(); i += step) {
        if (!fit.used[i]) continue;
        ++orientations;
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3 direction(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
            const auto square = [&](double reach_m) {
                const Pose at{pairs[i].device_from_stylus.rotation,
                              settings.cube.centre_m + reach_m * direction};
                const Rows rows = targetJacobian(fit, at, Vec3(0.0));
                return (rows * covariance * rows.transpose()).trace();
            };
            mean += square(inner_m) / 8.0;
            worst = std::max(worst, square(settings.cube.half_m));
        }
    }
    fit.tre = {std::sqrt(mean / std::max(1, orientations)), std::sqrt(worst)};
    fit.scale_sd = std::sqrt(covariance(kScale, kScale));
    fit.gimbal_sd_m = std::sqrt(covariance.block<3, 3>(kGimbal, kGimbal).trace());
    fit.latency_sd_s = std::sqrt(covariance(kLatency, kLatency));
}

std::string validatePairs(std::span<const Pair> pairs, const FitSettings& settings) {
    const int min_pairs = isTipVague(settings) ? kMinPairsForTip : kMinPairs;
    if (int(pairs.size()) < min_pairs)
        return fmt::format("{} points are too few: {} are needed.", pairs.size(), min_pairs);
    for (const Pair& pair : pairs)
        if (!isFinite(pair.device_from_stylus) || !isFinite(pair.stage_from_grip) ||
            !isFinite(pair.tip_m_per_s))
            return "A pose is not a number.";
    std::vector<Vec3> apart;
    for (const Vec3& tip : deviceTips(pairs))
        if (int(apart.size()) < kMinPairs && std::none_of(apart.begin(), apart.end(), [&](const Vec3& other) {
                return glm::distance(tip, other) < kMinDistance_m;
            }))
            apart.push_back(tip);
    if (int(apart.size()) < kMinPairs)
        return fmt::format("The same place was touched again and again: touch at least {} places.",
                           kMinPairs);
    return "";
}

std::string validateSpread(const Spread& spread) {
    if (spread.sizes_m.y < kMinThickness_m)
        return "The points lie on a line: touch places to its sides as well.";
    if (spread.sizes_m.z < kMinThickness_m) return "The points lie in a plane: touch places off it as well.";
    return "";
}

}  // namespace

std::vector<Vec3> deviceTips(std::span<const Pair> pairs) {
    std::vector<Vec3> tips;
    for (const Pair& pair : pairs)
        tips.push_back(pair.device_from_stylus.position_m);
    return tips;
}

Result<Fit> fitPairs(std::span<const Pair> pairs, const FitSettings& settings, const Fit* earlier) {
    if (const std::string why = validatePairs(pairs, settings); !why.empty()) return failure<Fit>(why);
    if (const std::string why = validateSpread(computeSpread(deviceTips(pairs))); !why.empty())
        return failure<Fit>(why);
    Result<Fit> found;
    if (earlier)
        found.value = *earlier, found.value->latency_s = 0.0;
    else
        found = consensus(pairs, settings);
    if (!found) return found;
    Fit& fit = *found.value;
    // The consensus ignores scale and gimbal offset, so good pairs have larger residuals at first. Start with
    // a wide threshold and tighten it.
    double threshold_m = 2.0 * fit.noise_m;
    for (int round = 0; round < kFitRounds; ++round) {
        const bool same = selectInliers(fit, pairs, threshold_m);
        if (fit.inliers < kMinPairs) return failure<Fit>("Too few of the points agree with one another.");
        if (round == 0) fit.effective_pairs = fit.inliers;
        for (int step = 0; step < kSteps; ++step) {
            const NormalEquations normal = makeNormalEquations(fit, pairs, settings);
            applyStep(fit, normal.matrix.ldlt().solve(normal.right));
        }
        measureNoise(fit, pairs, settings, countDetermined(fit, pairs, settings));
        if (same && round > 1) break;
        threshold_m = fit.noise_m;
    }
    std::vector<Pair> inliers;
    std::vector<Pose> grips;
    for (std::size_t i = 0; i < pairs.size(); ++i)
        if (fit.used[i]) inliers.push_back(pairs[i]), grips.push_back(pairs[i].stage_from_grip);
    fit.spread = computeSpread(deviceTips(inliers));
    if (const std::string why = validateSpread(fit.spread); !why.empty())
        return failure<Fit>("Of the points that agree with one another: " + why);
    fit.max_rotation_rad = maxRotation_rad(pairs.front().stage_from_grip.rotation, grips);
    predictErrors(fit, pairs, settings);
    if (!isFinite(fit.stage_from_device) || !std::isfinite(fit.tre.worst_m))
        return failure<Fit>("The points do not determine where the device stands: touch more places.");
    return found;
}

Verdict evaluateFit(const Fit& fit, const Limits& limits) {
    const double rejected = double(fit.rejected) / std::max(1, fit.inliers + fit.rejected);
    if (rejected > limits.rejected)
        return {false,
                fmt::format("{:.0f} % of the points contradict the rest: keep the tips together and do "
                            "it again.",
                            100.0 * rejected)};
    if (fit.fre_m > limits.fre_m)
        return {false,
                fmt::format("The points miss one another by {:.1f} mm: keep the tips together and do it "
                            "again.",
                            1e3 * fit.fre_m)};
    if (std::fabs(fit.scale - 1.0) > limits.scale)
        return {false,
                fmt::format("The device's millimetres and the headset's differ by {:.1f} %: is the device "
                            "calibrated and homed?",
                            100.0 * (fit.scale - 1.0))};
    if (glm::length(fit.stylus_from_tip_m) > limits.gimbal_m)
        return {false, fmt::format("The device's tip is {:.0f} mm from where it says: is its handle homed?",
                                   1e3 * glm::length(fit.stylus_from_tip_m))};
    if (fit.tre.mean_m > limits.tre_mean_m || fit.tre.worst_m > limits.tre_worst_m)
        return {false, fmt::format(
                           "The needle would be {:.1f} mm from where it is seen, {:.1f} at worst: touch more "
                           "places, farther apart.",
                           1e3 * fit.tre.mean_m, 1e3 * fit.tre.worst_m)};
    return {true, fmt::format(
                      "The needle will be seen about {:.1f} mm from where it is, {:.1f} in the worst corner.",
                      1e3 * fit.tre.mean_m, 1e3 * fit.tre.worst_m)};
}

}  // namespace stylet::xr::registration
