#include "haptics/tools/scalpel.h"
#include "base/hash.h"

#include <algorithm>
#include <cmath>

namespace stylet::haptics {

namespace {

// If `at_m` lies beyond one end of a straight cut, moves that end to `at_m`.
void extend(Incision& cut, const Vec3& at_m) noexcept {
    const double length_m = glm::length(cut.end_reference_m - cut.begin_reference_m);
    const double from_begin_m = glm::length(at_m - cut.begin_reference_m);
    const double from_end_m = glm::length(at_m - cut.end_reference_m);
    if (std::max(from_begin_m, from_end_m) <= length_m) return;
    (from_begin_m >= from_end_m ? cut.end_reference_m : cut.begin_reference_m) = at_m;
}

// The blade in one tick, and the state that it changes. All positions and axes are in the reference frame.
struct Blade {
    ScalpelState& s;
    Incisions& incisions;
    const ScalpelSettings& settings;
    const TouchPoint& skin;
    Vec3 point_m;
    Mat3 axes;  // edge, flat, handle

    // The blade on intact skin. Returns the extension of the spring between the blade and its proxy. Along
    // the skin's normal this is the full depth. Along the skin it is limited by friction, beyond which the
    // proxy slides.
    Vec3 touch() noexcept {
        if (!s.touching) s.proxy_reference_m = point_m;
        const Vec3 normal = unitOr(skin.level_slope, axes[2]);
        const Vec3 deep = skin.level_m * normal;
        Vec3 beside;
        dragProxy(s.proxy_reference_m, point_m, normal, settings.friction * glm::length(deep), beside);
        return deep + beside;
    }

    // The blade inside the body. Along each of its axes the proxy stays in place until the force exceeds the
    // tissue's resistance, then follows. Bone is not cut.
    Vec3 cut() noexcept {
        const bool on_bone = s.depth_m * skin.bone_per_m >= 1.0;
        Vec3 stretch = point_m - s.proxy_reference_m;
        const double most_n[] = {settings.along_edge_n, settings.across_blade_n, settings.deeper_n};
        for (int axis = 0; axis < 3; ++axis) {
            const double along_m = glm::dot(stretch, axes[axis]);
            const double most_m = most_n[axis] / settings.stiffness_n_per_m;
            if (std::fabs(along_m) <= most_m || (axis == 2 && on_bone && along_m < 0.0)) continue;
            stretch += (std::copysign(most_m, along_m) - along_m) * axes[axis];
        }
        s.proxy_reference_m = point_m - stretch;
        return stretch;
    }

    // Index of an incision that is open here, or -1.
    int findOpenIncision() const noexcept {
        for (int i = 0; i < incisions.count; ++i)
            if (isOpen(incisions.list[std::size_t(i)], s.skin_reference_m, settings.open_reach_m)) return i;
        return -1;
    }

    void startIncision() noexcept {
        s.cutting = true;
        s.incision = findOpenIncision();
        if (s.incision < 0 && incisions.count < kMaxIncisions) {
            s.incision = incisions.count++;
            incisions.list[std::size_t(s.incision)] = {s.skin_reference_m, s.skin_reference_m};
        }
    }

    void extendIncision() noexcept {
        if (s.incision < 0) return;
        Incision& mine = incisions.list[std::size_t(s.incision)];
        extend(mine, s.skin_reference_m);
        extend(mine, s.skin_reference_m + settings.width_per_depth * s.depth_m * axes[0]);
    }
};

}  // namespace

ToolForce stepScalpel(ScalpelState& s, Incisions& incisions, const ScalpelSettings& settings,
                      const BreathingSkin& breathing_skin, const Pose& patient_from_tool) noexcept {
    const Mat3 frame = glm::mat3_cast(patient_from_tool.rotation);
    const Vec3 tip_m = patient_from_tool.position_m;
    ToolForce force;
    if (s.primed) force.tissue_moved_m = skinDisplacement(breathing_skin, s.breath, s.skin_reference_m);
    force.event = !s.primed;

    LocalBreathingMap toReference = breathingMapAt(breathing_skin, tip_m + s.depth_m * s.outward);
    addSlope(toReference, breathing_skin, frame);
    const Mat3 back = glm::transpose(toReference.slope);
    const Vec3 point_m = toReference(tip_m);
    const TouchPoint skin = touchAt(breathing_skin.map, point_m);
    s.outward = unitOr(back * skin.level_slope, Vec3(0.0));
    s.depth_m = std::clamp(-skin.level_m, 0.0, kDeepestTip_m);
    s.skin_reference_m = toReference(tip_m + s.depth_m * s.outward);
    if (s.depth_m > 0.0) {
        Mat3 axes = toReference.slope * frame;
        for (int axis = 0; axis < 3; ++axis)
            axes[axis] = unitOr(axes[axis], frame[axis]);
        Blade blade{s, incisions, settings, skin, point_m, axes};
        Vec3 stretch = s.cutting ? blade.cut() : blade.touch();
        s.touching = true;
        if (!s.cutting && (settings.stiffness_n_per_m * s.depth_m >= settings.cut_force_n ||
                           blade.findOpenIncision() >= 0)) {
            s.proxy_reference_m = point_m - stretch;
            blade.startIncision();
            stretch = blade.cut();
            force.event = true;
        }
        if (s.cutting) blade.extendIncision();
        force.force_n = back * (-settings.stiffness_n_per_m * stretch);
        force.energy_j = 0.5 * settings.stiffness_n_per_m * glm::dot(stretch, stretch);
    } else {
        force.event = force.event || s.cutting;  // the tissue releases the blade
        s.touching = s.cutting = false;
        s.incision = -1;
    }
    s.breath = breathing_skin.breath;
    s.primed = true;
    return force;
}

void hashScalpel(StateHash& hash, const ScalpelState& s) noexcept {
    hash.add(std::uint64_t(s.touching) | std::uint64_t(s.cutting) << 1 | std::uint64_t(s.primed) << 2 |
             std::uint64_t(std::uint32_t(s.incision)) << 32);
    hash.add(s.proxy_reference_m, s.skin_reference_m, s.outward, s.depth_m);
    patient::hashSurrogate(hash, s.breath);
}

}  // namespace stylet::haptics
