#include "haptics/passivity.h"

#include <algorithm>

namespace stylet::haptics {

namespace {

const SentForce& acting(const PassivityState& s, int delay_ticks) noexcept {
    const std::uint32_t size = std::uint32_t(s.sent.size());
    return s.sent[(s.newest + size - std::uint32_t(delay_ticks)) % size];
}

Vec3 relative(const Motion& m) noexcept {
    return m.tip_moved_m - m.tissue_moved_m;
}

}  // namespace

void observe(PassivityState& s, const Motion& m, int delay_ticks) noexcept {
    const SentForce& force = acting(s, delay_ticks);
    const Vec3 along = relative(m);
    // By the hand (and by the breath, which moves the tissue) against what was sent.
    const double work_j =
        -glm::dot(force.force_n - force.wall_n, along) - glm::dot(force.wall_n, m.tip_moved_m);
    // At an event the springs are exchanged: neither a rise of S (a softer tissue under the same force) nor
    // its fall (a cut) is the hand's doing. What is, is the work against the model's mean force.
    const double stored_j = m.event ? -0.5 * glm::dot(s.model_n + m.model_n, along) : m.energy_j - s.energy_j;
    const double wall_j = m.wall_energy_j - s.wall_energy_j;
    s.shortfall_j =
        std::max(0.0, s.shortfall_j + force.scale * stored_j + force.wall_scale * wall_j - work_j);
    s.model_n = m.model_n;
    s.energy_j = m.energy_j;
    s.wall_energy_j = m.wall_energy_j;
}

Vec3 takeBack(const PassivityState& s, const Motion& m, int delay_ticks, double most_n_per_m) noexcept {
    const Vec3 along = relative(m);
    const double way2 = glm::dot(along, along);
    if (s.shortfall_j <= 0.0 || way2 <= 0.0) return Vec3(0.0);
    // Behind a delay as many answers are on their way as it has ticks: each pays its share.
    const double share_j = s.shortfall_j / (1.0 + delay_ticks);
    return -std::min(share_j / way2, most_n_per_m) * along;
}

void remember(PassivityState& s, const SentForce& sent) noexcept {
    s.newest = (s.newest + 1) % std::uint32_t(s.sent.size());
    s.sent[s.newest] = sent;
}

void hashPassivity(patient::StateHash& hash, const PassivityState& s) noexcept {
    const SentForce& sent = s.sent[s.newest];  // the older ones were added in their ticks
    hash.add(sent.force_n);
    hash.add(sent.wall_n);
    hash.add(sent.scale);
    hash.add(sent.wall_scale);
    hash.add(s.model_n);
    hash.add(s.energy_j);
    hash.add(s.wall_energy_j);
    hash.add(s.shortfall_j);
}

}  // namespace stylet::haptics
