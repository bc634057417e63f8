#include "xr/registration/rigid.h"

#include <algorithm>
#include <limits>

#include "xr/registration/eigen.h"

namespace stylet::xr::registration {
namespace {

// Points closer to a line than this do not determine the rotation about it.
constexpr double kMinLineSpread_m = 0.002;

Vec3 toGlm(const Eigen::Vector3d& v) {
    return {v.x(), v.y(), v.z()};
}

Vec3 meanOf(std::span<const Vec3> points_m) {
    Vec3 sum(0.0);
    for (const Vec3& p : points_m)
        sum += p;
    return sum / double(points_m.size());
}

Quat toQuat(const Eigen::Matrix3d& m) {
    const Eigen::Quaterniond q(m);
    return glm::normalize(Quat(q.w(), q.x(), q.y(), q.z()));
}

bool isCollinear(const Spread& spread) {
    return spread.sizes_m.y < kMinLineSpread_m;
}

}  // namespace

Spread computeSpread(std::span<const Vec3> points_m) {
    Spread spread;
    if (points_m.empty()) return spread;
    spread.centre_m = meanOf(points_m);
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const Vec3& p : points_m) {
        const Eigen::Vector3d d = eigen(p - spread.centre_m);
        scatter += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solved(scatter / double(points_m.size()));
    for (int k = 0; k < 3; ++k) {
        spread.axes[std::size_t(k)] = toGlm(solved.eigenvectors().col(2 - k));
        spread.sizes_m[k] = std::sqrt(std::max(0.0, solved.eigenvalues()[2 - k]));
    }
    return spread;
}

Result<RigidFit> fitRigid(std::span<const Vec3> a_m, std::span<const Vec3> b_m, bool with_scale) {
    if (a_m.size() != b_m.size()) return failure<RigidFit>("The two sets have different numbers of points.");
    if (a_m.size() < 3) return failure<RigidFit>("Three points are needed at least.");
    const auto finite = [](const Vec3& p) { return isFinite(p); };
    if (!std::all_of(a_m.begin(), a_m.end(), finite) || !std::all_of(b_m.begin(), b_m.end(), finite))
        return failure<RigidFit>("A point is not a number.");
    for (const std::span<const Vec3>& points : {a_m, b_m})
        if (isCollinear(computeSpread(points)))
            return failure<RigidFit>("The points lie on a line, or all in one place.");

    const double n = double(a_m.size());
    const Vec3 a_mean = meanOf(a_m), b_mean = meanOf(b_m);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double b_variance = 0.0;
    for (std::size_t i = 0; i < a_m.size(); ++i) {
        covariance += eigen(a_m[i] - a_mean) * eigen(b_m[i] - b_mean).transpose() / n;
        b_variance += glm::dot(b_m[i] - b_mean, b_m[i] - b_mean) / n;
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign(1.0, 1.0, 1.0);  // excludes a reflection
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign.z() = -1.0;
    const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();

    RigidFit fit;
    fit.a_from_b.rotation = toQuat(rotation);
    if (with_scale) fit.scale = svd.singularValues().dot(sign) / b_variance;
    fit.a_from_b.position_m = a_mean - fit.a_from_b.rotation * (fit.scale * b_mean);
    double squares = 0.0;
    for (std::size_t i = 0; i < a_m.size(); ++i) {
        const Vec3 off = fit.a_from_b * (fit.scale * b_m[i]) - a_m[i];
        squares += glm::dot(off, off);
    }
    fit.fre_m = std::sqrt(squares / n);
    return {fit, ""};
}

namespace {

// TRE^2 / FLE^2 at a target with squared distance d2[k] from axis k.
double treFactor(const Spread& spread, double points, const std::array<double, 3>& d2_m2) {
    double sum = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double u = spread.sizes_m[int((k + 1) % 3)], v = spread.sizes_m[int((k + 2) % 3)];
        const double f2_m2 = u * u + v * v;
        if (f2_m2 <= 0.0) return std::numeric_limits<double>::infinity();
        sum += d2_m2[k] / f2_m2;
    }
    return (1.0 + sum / 3.0) / points;
}

std::array<double, 3> fromAxes_m2(const Spread& spread, const Vec3& target_m) {
    const Vec3 away = target_m - spread.centre_m;
    std::array<double, 3> d2{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double along = glm::dot(away, spread.axes[k]);
        d2[k] = std::max(0.0, glm::dot(away, away) - along * along);
    }
    return d2;
}

}  // namespace

double expectedTre_m(std::span<const Vec3> points_m, double fle_m, const Vec3& target_m) {
    const Spread spread = computeSpread(points_m);
    if (points_m.size() < 3 || isCollinear(spread)) return std::numeric_limits<double>::infinity();
    return fle_m * std::sqrt(treFactor(spread, double(points_m.size()), fromAxes_m2(spread, target_m)));
}

double expectedFre_m(int points, double fle_m) {
    return points < 3 ? 0.0 : fle_m * std::sqrt(1.0 - 2.0 / points);
}

CubeError expectedTreInCube(const Cube& cube, std::span<const Vec3> points_m, double fle_m) {
    const Spread spread = computeSpread(points_m);
    constexpr double kNever = std::numeric_limits<double>::infinity();
    if (points_m.size() < 3 || isCollinear(spread)) return {kNever, kNever};
    const double n = double(points_m.size());
    // Mean squared distance of a cube's points from an axis through its centre: half^2 / 3 in each of the
    // two perpendicular directions.
    std::array<double, 3> mean = fromAxes_m2(spread, cube.centre_m);
    for (double& d2 : mean)
        d2 += 2.0 / 3.0 * cube.half_m * cube.half_m;
    CubeError error{fle_m * std::sqrt(treFactor(spread, n, mean)), 0.0};
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 direction(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
        const auto d2 = fromAxes_m2(spread, cube.centre_m + cube.half_m * direction);
        error.worst_m = std::max(error.worst_m, fle_m * std::sqrt(treFactor(spread, n, d2)));
    }
    return error;
}

}  // namespace stylet::xr::registration
