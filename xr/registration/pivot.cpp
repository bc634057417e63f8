#include "xr/registration/pivot.h"

#include <algorithm>
#include <vector>

#include "xr/registration/eigen.h"

namespace stylet::xr::registration {
namespace {

constexpr std::size_t kLeastPoses = 8;
constexpr double kLeastTurn_rad = 25.0 * 0.017453292519943295;
// Lower bound of the smallest eigenvalue per pose. If all rotations share one axis, the tip's position
// along that axis is undetermined.
constexpr double kLeastShare = 1e-3;
constexpr double kPoseOutlier = 4.0, kFinestPivot_m = 1e-4;
constexpr int kPivotRounds = 4;

struct Solved {
    Eigen::Matrix<double, 6, 1> tip_and_pivot;
    Eigen::Matrix<double, 6, 6> normal;
};

Solved solve(const std::vector<Rigid>& poses) {
    Solved solved;
    solved.normal.setZero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (const Rigid& pose : poses) {
        Eigen::Matrix<double, 3, 6> row;
        row << toMatrix(pose.rotation), -Eigen::Matrix3d::Identity();
        solved.normal += row.transpose() * row;
        right -= row.transpose() * eigen(pose.position_m);
    }
    solved.tip_and_pivot = solved.normal.ldlt().solve(right);
    return solved;
}

double offOf(const Rigid& pose, const Solved& solved) {
    return (toMatrix(pose.rotation) * solved.tip_and_pivot.head<3>() + eigen(pose.position_m) -
            solved.tip_and_pivot.tail<3>())
        .norm();
}

double leastShare(const Solved& solved, std::size_t poses) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> values(solved.normal / double(poses));
    return values.eigenvalues()[0];
}

double mostTurned_rad(std::span<const Rigid> poses) {
    double most = 0.0;
    // Compares with the first pose, then with the pose farthest from it. Within a few per cent of the
    // maximum over all pairs.
    Quat from = poses.front().rotation;
    for (int round = 0; round < 2; ++round) {
        Quat farthest = from;
        for (const Rigid& pose : poses) {
            const double turn = angleBetween(from, pose.rotation);
            if (turn > most) most = turn, farthest = pose.rotation;
        }
        from = farthest;
    }
    return most;
}

}  // namespace

Answer<Pivot> calibratePivot(std::span<const Rigid> stage_from_grip) {
    if (stage_from_grip.size() < kLeastPoses) return refused<Pivot>("Eight poses are needed at least.");
    for (const Rigid& pose : stage_from_grip)
        if (!isFinite(pose)) return refused<Pivot>("A pose is not a number.");
    Pivot pivot;
    pivot.turned_rad = mostTurned_rad(stage_from_grip);
    if (pivot.turned_rad < kLeastTurn_rad)
        return refused<Pivot>("The controller was turned too little to tell where its tip is.");

    std::vector<Rigid> kept(stage_from_grip.begin(), stage_from_grip.end());
    Solved solved = solve(kept);
    if (leastShare(solved, kept.size()) < kLeastShare)
        return refused<Pivot>(
            "The controller was turned about one axis only: tilt it to the side and forth as well.");
    for (int round = 0; round < kPivotRounds; ++round) {
        std::vector<double> off;
        for (const Rigid& pose : stage_from_grip)
            off.push_back(offOf(pose, solved));
        std::vector<double> sorted = off;
        std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
        const double most = kPoseOutlier * std::max(kFinestPivot_m, sorted[sorted.size() / 2] / 1.538);
        kept.clear();
        for (std::size_t i = 0; i < off.size(); ++i)
            if (off[i] <= most) kept.push_back(stage_from_grip[i]);
        solved = solve(kept);
    }
    double squares = 0.0;
    for (const Rigid& pose : kept)
        squares += offOf(pose, solved) * offOf(pose, solved);
    const double least = leastShare(solved, kept.size());
    if (least < kLeastShare)
        return refused<Pivot>("Too few of the poses agree on where the tip is: keep it in its place.");
    pivot.grip_from_tip_m = {solved.tip_and_pivot[0], solved.tip_and_pivot[1], solved.tip_and_pivot[2]};
    pivot.stage_from_pivot_m = {solved.tip_and_pivot[3], solved.tip_and_pivot[4], solved.tip_and_pivot[5]};
    pivot.residual_m = std::sqrt(squares / double(kept.size()));
    pivot.tip_sd_m = pivot.residual_m / std::sqrt(3.0 * double(kept.size()) * least);
    return {pivot, ""};
}

}  // namespace stylet::xr::registration
