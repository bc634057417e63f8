#include "haptics/output/stored_energy.h"

#include <algorithm>
#include <cmath>

#include "haptics/tools/device.h"

namespace stylet::haptics {

ToolForce boundByStoredEnergy(StoredEnergy& s, const ToolForce& tool, const Vec3& moved_m) noexcept {
    if (!isFinite(tool.force_n) || !isFinite(tool.tissue_moved_m) || !std::isfinite(tool.energy_j))
        return tool;
    const double share = s.share();
    const Vec3 mean_n = 0.5 * share * (s.force_n + tool.force_n);
    const double work_j = -glm::dot(mean_n, moved_m - tool.tissue_moved_m);
    const double before_j = share * s.springs_j, elastic_j = share * tool.energy_j;
    // Between events the springs stretch and relax elastically, and work beyond that went into friction. An
    // event replaces the springs: they hold what the hand had put in before, plus its work in this tick.
    const double by_hand_j =
        tool.event ? before_j + work_j : elastic_j + std::max(0.0, work_j - (elastic_j - before_j));
    s.springs_j = tool.energy_j;
    s.by_hand_j = std::clamp(by_hand_j, 0.0, std::max(0.0, tool.energy_j));
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
