#include "world/spaces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenario/openxr_later.h"

namespace xrmock {

Pose stageFromHead(const Instance& instance, std::int64_t time_ns) {
    return poseAt(instance.scenario.head, instance.clock.scenarioSeconds(time_ns));
}

Pose stageFromLocal(const Instance& instance, std::int64_t time_ns) {
    return originAt(instance.conditions.local, time_ns);
}

Pose stageFromLocalFloor(const Instance& instance, std::int64_t time_ns) {
    Pose floor = stageFromLocal(instance, time_ns);
    floor.position[1] = originAt(instance.conditions.stage, time_ns).position[1];
    return floor;
}

std::array<Pose, 2> stageFromEyes(const Instance& instance, std::int64_t time_ns) {
    const Pose stage_from_head = stageFromHead(instance, time_ns);
    const double half_m = instance.scenario.ipd_m / 2;
    const double half_rad = instance.scenario.eye_turn_rad / 2;
    const double sine = std::sin(half_rad), cosine = std::cos(half_rad);
    return {stage_from_head * Pose{{0, sine, 0, cosine}, {-half_m, 0, 0}},
            stage_from_head * Pose{{0, -sine, 0, cosine}, {half_m, 0, 0}}};
}

namespace {

// Pose of the space at `time_ns`. The origins of the reference spaces are those at `origins_ns`.
std::optional<Pose> stageFromSpace(const Space& space, std::int64_t time_ns, std::int64_t origins_ns) {
    const Instance& instance = space.session.instance;
    switch (int{space.reference}) {
        case XR_REFERENCE_SPACE_TYPE_VIEW:
            return stageFromHead(instance, time_ns) * space.origin_from_space;
        case XR_REFERENCE_SPACE_TYPE_LOCAL:
            return stageFromLocal(instance, origins_ns) * space.origin_from_space;
        case XR_REFERENCE_SPACE_TYPE_STAGE:
            return originAt(instance.conditions.stage, origins_ns) * space.origin_from_space;
        case XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR_EXT:
            return stageFromLocalFloor(instance, origins_ns) * space.origin_from_space;
        case XR_REFERENCE_SPACE_TYPE_STATIONARY_EXT:
            return originAt(instance.conditions.stationary, origins_ns) * space.origin_from_space;
        default:
            break;
    }
    const auto stage_from_action = stageFromAction(space.session.input, makeSources(space.session),
                                                   space.action, space.subaction_path, time_ns);
    if (!stage_from_action) return std::nullopt;
    return *stage_from_action * space.origin_from_space;
}

std::optional<Pose> baseFromSpace(const Space& base, const Space& space, std::int64_t time_ns,
                                  std::int64_t origins_ns) {
    const std::optional<Pose> stage_from_base = stageFromSpace(base, time_ns, origins_ns);
    const std::optional<Pose> stage_from_space = stageFromSpace(space, time_ns, origins_ns);
    if (!stage_from_base || !stage_from_space) return std::nullopt;
    return inverse(*stage_from_base) * *stage_from_space;
}

}  // namespace

std::optional<Pose> stageFromSpace(const Space& space, std::int64_t time_ns) {
    return stageFromSpace(space, time_ns, time_ns);
}

std::optional<Pose> baseFromSpace(const Space& base, const Space& space, std::int64_t time_ns) {
    return baseFromSpace(base, space, time_ns, time_ns);
}

Velocity centralDifference(const Pose& before, const Pose& after) {
    constexpr double kPerSecond = 1e9 / (2.0 * kStepNs);
    Velocity velocity{{}, rotationBetween(before, after)};
    for (std::size_t i = 0; i < 3; ++i) {
        velocity.linear_m_per_s[i] = (after.position[i] - before.position[i]) * kPerSecond;
        velocity.angular_rad_per_s[i] *= kPerSecond;
    }
    return velocity;
}

// Uses fixed origins, because recentring is not motion.
std::optional<Velocity> velocityInBase(const Space& base, const Space& space, std::int64_t time_ns) {
    time_ns = std::min(time_ns, std::numeric_limits<std::int64_t>::max() - kStepNs);
    const std::optional<Pose> before = baseFromSpace(base, space, time_ns - kStepNs, time_ns);
    const std::optional<Pose> after = baseFromSpace(base, space, time_ns + kStepNs, time_ns);
    if (!before || !after) return std::nullopt;
    return centralDifference(*before, *after);
}

}  // namespace xrmock
