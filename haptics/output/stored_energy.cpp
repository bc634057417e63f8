#include "haptics/output/stored_energy.h"

#include <algorithm>
#include <cmath>

#include "haptics/tools/device.h"

namespace stylet::haptics {

ToolForce boundByStoredEnergy(StoredEnergy& s, const ToolForce& tool, const Vec3& moved_m) noexcept {
    if (!isFinite(tool.force_n) || !isFinite(tool.tissue_moved_m) || !std::isfinite(tool.energy_j))
        return tool;
    const Vec3 mean_n = 0.5 * (s.force_n + tool.force_n);
    const double work_j = -glm::dot(mean_n, moved_m - tool.tissue_moved_m), springs_j = tool.energy_j;
    if (tool.event) {
        // The springs are replaced: they hold what the hand had put in before, plus its work in this tick.
        s.by_hand_j = std::clamp(s.by_hand_j + s.share() * work_j, std::min(0.0, springs_j), springs_j);
    } else {
        // The springs stretch and relax elastically. Work beyond that went into friction.
        const double friction_j = std::max(0.0, work_j - (springs_j - s.springs_j));
        const double root = std::sqrt(std::max(0.0, springs_j));
        double missing = std::sqrt(std::max(0.0, s.springs_j)) - std::sqrt(std::max(0.0, s.by_hand_j));
        missing = std::min(missing, root);
        if (missing > 0.0) missing = std::max(0.0, missing - 0.5 * friction_j / root);
        s.by_hand_j = missing > 0.0 ? (root - missing) * (root - missing) : springs_j;
    }
    s.springs_j = springs_j;
    s.force_n = tool.force_n;
    ToolForce bounded = tool;
    bounded.force_n *= s.share();
    bounded.torque_n_m *= s.share();
    bounded.energy_j = s.by_hand_j;
    return bounded;
}

void hashStoredEnergy(StateHash& hash, const StoredEnergy& s) noexcept {
    hash.add(s.springs_j, s.by_hand_j, s.force_n);
}

}  // namespace stylet::haptics
