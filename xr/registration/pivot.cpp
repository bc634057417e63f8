#include "xr/registration/pivot.h"

#include <algorithm>
#include <vector>

#include "base/statistics.h"
#include "xr/registration/eigen.h"

namespace stylet::xr::registration {
namespace {

constexpr std::size_t kMinPoses = 8;
constexpr double kMinRotation_rad = 25.0 * 0.017453292519943295;
// Lower bound of the smallest eigenvalue per pose. If all rotations share one axis, the tip's position
// along that axis is undetermined.
constexpr double kMinEigenvalue = 1e-3;
constexpr double kPoseOutlier = 4.0, kMinResidual_m = 1e-4;
constexpr double kMedianPerSd = 1.538;  // median length of a 3D normal error, in standard deviations
constexpr int kPivotRounds = 4;

struct Solved {
    Eigen::Matrix<double, 6, 1> tip_and_pivot;
    Eigen::Matrix<double, 6, 6> normal;
};

Solved solve(const std::vector<Pose>& poses) {
    Solved solved;
    solved.normal.setZero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (const Pose& pose : poses) {
        Eigen::Matrix<double, 3, 6> row;
        row << toMatrix(pose.rotation), -Eigen::Matrix3d::Identity();
        solved.normal += row.transpose() * row;
        right -= row.transpose() * eigen(pose.position_m);
    }
    solved.tip_and_pivot = solved.normal.ldlt().solve(right);
    return solved;
}

double residualLength(const Pose& pose, const Solved& solved) {
    return (toMatrix(pose.rotation) * solved.tip_and_pivot.head<3>() + eigen(pose.position_m) -
            solved.tip_and_pivot.tail<3>())
        .norm();
}

double smallestEigenvalue(const Solved& solved, std::size_t poses) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> values(solved.normal / double(poses));
    return values.eigenvalues()[0];
}

}  // namespace

Result<Pivot> calibratePivot(std::span<const Pose> stage_from_grip) {
    if (stage_from_grip.size() < kMinPoses) return failure<Pivot>("Eight poses are needed at least.");
    for (const Pose& pose : stage_from_grip)
        if (!isFinite(pose)) return failure<Pivot>("A pose is not a number.");
    Pivot pivot;
    pivot.max_rotation_rad = maxRotation_rad(stage_from_grip.front().rotation, stage_from_grip);
    if (pivot.max_rotation_rad < kMinRotation_rad)
        return failure<Pivot>("The controller was turned too little to tell where its tip is.");

    std::vector<Pose> kept(stage_from_grip.begin(), stage_from_grip.end());
    Solved solved = solve(kept);
    if (smallestEigenvalue(solved, kept.size()) < kMinEigenvalue)
        return failure<Pivot>(
            "The controller was turned about one axis only: tilt it to the side and forth as well.");
    for (int round = 0; round < kPivotRounds; ++round) {
        std::vector<double> off;
        for (const Pose& pose : stage_from_grip)
            off.push_back(residualLength(pose, solved));
        const double most = kPoseOutlier * std::max(kMinResidual_m, upperMedian(off) / kMedianPerSd);
        kept.clear();
        for (std::size_t i = 0; i < off.size(); ++i)
            if (off[i] <= most) kept.push_back(stage_from_grip[i]);
        solved = solve(kept);
    }
    double squares = 0.0;
    for (const Pose& pose : kept)
        squares += residualLength(pose, solved) * residualLength(pose, solved);
    const double least = smallestEigenvalue(solved, kept.size());
    if (least < kMinEigenvalue)
        return failure<Pivot>("Too few of the poses agree on where the tip is: keep it in its place.");
    pivot.grip_from_tip_m = {solved.tip_and_pivot[0], solved.tip_and_pivot[1], solved.tip_and_pivot[2]};
    pivot.stage_from_pivot_m = {solved.tip_and_pivot[3], solved.tip_and_pivot[4], solved.tip_and_pivot[5]};
    pivot.residual_m = std::sqrt(squares / double(kept.size()));
    pivot.tip_sd_m = pivot.residual_m / std::sqrt(3.0 * double(kept.size()) * least);
    return {pivot, ""};
}

}  // namespace stylet::xr::registration
