#include "haptics/output/passivity.h"

#include <algorithm>

namespace stylet::haptics {

namespace {

const SentForce& actingForce(const PassivityState& s, int delay_ticks) noexcept {
    const std::uint32_t size = std::uint32_t(s.sent.size());
    return s.sent[(s.newest + size - std::uint32_t(delay_ticks)) % size];
}

// Records the tip's motion. Returns the part that counts.
Vec3 recordMotion(PassivityState& s, const Vec3& moved_m) noexcept {
    constexpr std::uint32_t kLongest = 1u << 20;
    Vec3 counts_m = moved_m;
    for (int k = 0; k < 3; ++k) {
        const std::size_t i = std::size_t(k);
        if (moved_m[k] == 0.0) {
            s.still[i] = std::min(s.still[i] + 1, kLongest);
            continue;
        }
        const std::int32_t sense = moved_m[k] > 0.0 ? 1 : -1;
        const bool in_last_tick = s.still[i] == 0;
        if (sense == -s.sense[i] && !(in_last_tick && s.steady[i])) counts_m[k] = 0.0;
        s.steady[i] = in_last_tick && sense == s.sense[i];
        s.sense[i] = sense;
        s.reported_motion_m[k] = counts_m[k];
        s.spread[i] = s.still[i] + 1;
        s.still[i] = 0;
    }
    return counts_m;
}

// Work done by the hand during this tick's motion against the forces that acted.
struct Work {
    double springs_j = 0.0, wall_j = 0.0, controller_j = 0.0;
    double slow = 0.0;  // 0: motion reported in every tick; toward 1: encoder counts far apart
    // Extra energy that the springs create when a count is reported at once instead of in even steps.
    double bunched_j = 0.0;
};

Work computeWork(const PassivityState& s, const Motion& m, const Vec3& moved_m, int delay_ticks) noexcept {
    const SentForce& now = actingForce(s, delay_ticks);
    Work work;
    // The tissue moves evenly, so this tick's force applies.
    work.springs_j = glm::dot(now.force_n - now.wall_n - now.controller_n, m.tissue_moved_m);
    work.controller_j = glm::dot(now.controller_n, m.tissue_moved_m);
    double reported2 = 0.0, late2 = 0.0;
    for (int k = 0; k < 3; ++k) {
        if (moved_m[k] == 0.0) continue;
        const int ticks = int(std::min<std::uint32_t>(s.spread[std::size_t(k)], kMaxSpreadTicks));
        double all_n = 0.0, wall_n = 0.0, controller_n = 0.0;
        for (int i = 0; i < ticks; ++i) {
            const SentForce& f = actingForce(s, delay_ticks + i);
            all_n += f.force_n[k], wall_n += f.wall_n[k], controller_n += f.controller_n[k];
        }
        const double motion_m = moved_m[k] / double(ticks);
        work.springs_j -= (all_n - wall_n - controller_n) * motion_m;
        work.wall_j -= wall_n * motion_m;
        work.controller_j -= controller_n * motion_m;
        const double stiffer_j = -0.5 * now.scale * (m.model_n[k] - s.model_n[k]) * moved_m[k];
        const double late = 1.0 - 1.0 / double(ticks);
        work.bunched_j += stiffer_j * late;
        reported2 += moved_m[k] * moved_m[k];
        late2 += moved_m[k] * moved_m[k] * late;
    }
    if (reported2 > 0.0) work.slow = late2 / reported2;
    return work;
}

// Estimated speed of the tip, and the number of ticks over which its next count is spread.
struct Pace {
    Vec3 motion_m{0.0};  // motion per tick
    double ticks = 1.0;
};

Pace estimatePace(const PassivityState& s, const Vec3& tissue_moved_m) noexcept {
    Pace pace;
    const double tissue2 = glm::dot(tissue_moved_m, tissue_moved_m);
    double ticks = tissue2, all = tissue2;
    for (int k = 0; k < 3; ++k) {
        const std::size_t i = std::size_t(k);
        // If no count came for longer than the last one took, the tip is slower. After twice that time it is
        // at rest.
        if (s.still[i] >= 2 * s.spread[i]) continue;
        pace.motion_m[k] = s.reported_motion_m[k] / double(std::max(s.spread[i], s.still[i] + 1));
        const double motion2 = pace.motion_m[k] * pace.motion_m[k];
        ticks += motion2 * double(s.spread[i]);
        all += motion2;
    }
    pace.motion_m -= tissue_moved_m;
    if (all > 0.0) pace.ticks = ticks / all;
    return pace;
}

}  // namespace

void observe(PassivityState& s, const Motion& m, int delay_ticks) noexcept {
    const Vec3 moved_m = recordMotion(s, m.tip_moved_m);
    const Work work = computeWork(s, m, moved_m, delay_ticks);
    const SentForce& force = actingForce(s, delay_ticks);
    // At an event the springs are replaced. A fall of S (a puncture) is no work of the hand, so the hand's
    // work against the model's mean force counts instead. A rise counts (stored_energy.h allows none).
    const Vec3 mean_n = 0.5 * (s.model_n + m.model_n);
    const double change_j = m.energy_j - s.energy_j;
    const double stored_j = m.event ? std::max(change_j, -glm::dot(mean_n, moved_m - m.tissue_moved_m))
                                    : change_j + glm::dot(mean_n, m.tip_moved_m - moved_m);
    const double wall_j = m.wall_energy_j - s.wall_energy_j;
    const double given_j = force.scale * stored_j - work.springs_j - std::max(0.0, work.bunched_j) +
                           force.wall_scale * wall_j - work.wall_j;
    const double margin = given_j > 0.0 ? kMargin + (kSlowMargin - kMargin) * work.slow : 1.0;
    s.excess_energy_j = std::max(0.0, s.excess_energy_j + margin * given_j - work.controller_j);
    s.model_n = m.model_n;
    s.energy_j = m.energy_j;
    s.wall_energy_j = m.wall_energy_j;
}

Vec3 dissipate(const PassivityState& s, const Motion& m, int delay_ticks, double max_n_per_m) noexcept {
    const Pace pace = estimatePace(s, m.tissue_moved_m);
    const double motion2 = glm::dot(pace.motion_m, pace.motion_m);
    if (s.excess_energy_j <= 0.0 || motion2 <= 0.0) return Vec3(0.0);
    // With a delay of n ticks, n corrections are in transit, so each dissipates only its share.
    const double share_j = s.excess_energy_j / (pace.ticks + delay_ticks);
    return -std::min(share_j / motion2, max_n_per_m) * pace.motion_m;
}

void recordSentForce(PassivityState& s, const SentForce& sent) noexcept {
    s.newest = (s.newest + 1) % std::uint32_t(s.sent.size());
    s.sent[s.newest] = sent;
}

void hashPassivity(StateHash& hash, const PassivityState& s) noexcept {
    const SentForce& sent = s.sent[s.newest];  // older entries were hashed in their own ticks
    hash.add(sent.force_n, sent.wall_n, sent.scale, sent.wall_scale);
    hash.add(s.model_n, s.energy_j, s.wall_energy_j, s.excess_energy_j);
    hash.add(sent.controller_n, s.reported_motion_m);
    for (std::size_t i = 0; i < 3; ++i)
        hash.add(std::uint64_t(s.spread[i]) | std::uint64_t(s.still[i]) << 32,
                 std::uint64_t(s.sense[i] + 1) | std::uint64_t(s.steady[i]) << 2);
}

}  // namespace stylet::haptics
