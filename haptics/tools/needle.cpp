#include "haptics/tools/needle.h"

#include <algorithm>

#include "base/hash.h"
#include "base/traversal.h"
#include "haptics/tools/needle_section.h"
#include "haptics/tools/tenting.h"

namespace stylet::haptics {

using patient::Patient;
using patient::Surrogate;
using patient::TissueSample;

namespace {

void placeChannel(NeedleState& s, const patient::MotionModel& motion, const Surrogate& breath,
                  const Vec3& deformed_m) noexcept {
    s.channel_side = patient::sideAt(motion, breath, deformed_m);
    s.channel_reference_m = patient::referenceFromDeformed(motion, breath, s.channel_side, deformed_m);
}

void prime(NeedleState& s, const Patient& patient, const Vec3& tip_deformed_m,
           const Surrogate& breath) noexcept {
    placeChannel(s, patient.package().motion, breath, tip_deformed_m);
    const TissueSample x = patient.at(s.channel_reference_m, s.track);
    s.tissue = x.tissue;
    s.label = x.label;
    if (x.tissue != Tissue::air) {
        s.phase = Phase::pass;
        s.track = patient.flagsAfterEntering(x, s.track);
    }
    s.tip_deformed_m = tip_deformed_m;
    s.breath = breath;
    s.fold_count = 0;
    s.primed = true;
}

// A path this short and this far from the sliding surfaces of the breathing model is straight in the
// reference frame too.
constexpr double kShortPath_m = 0.0005, kClearOfSides_m = 0.001;

// Returns false for NaN.
bool isStraightPath(const NeedleState& s, const Vec3& step_m) noexcept {
    const patient::LocalMotion& near = s.channel_motion;
    const bool inside = s.channel_side == patient::Side::inside;
    const double moved_m = glm::length(s.channel_reference_m - near.reference_m);
    return near.side == s.channel_side && moved_m + glm::length(step_m) <= kShortPath_m &&
           (inside ? -near.level_m : near.level_m) >= kClearOfSides_m;
}

// Visits every voxel from the current channel point to `to_reference_m`, each with its share of `travel_m`.
void walk(NeedleState& s, SectionSolver& solver, const Grid& grid, const Vec3& to_reference_m,
          double travel_m, Direction direction) noexcept {
    const Vec3 from = s.channel_reference_m;
    for (VoxelWalk w(grid, from, to_reference_m); !w.done(); w.next()) {
        solver.run(w.voxel(), from + w.begin() * (to_reference_m - from), (w.end() - w.begin()) * travel_m,
                   direction);
    }
    s.channel_reference_m = to_reference_m;
}

// Position of the channel in the deformed patient during one tick.
struct Course {
    const Patient& patient;
    const patient::MotionModel& motion;
    const Surrogate& breath;
    Vec3 at_m;

    Vec3 reference(const NeedleState& s, const Vec3& deformed_m) const noexcept {
        return patient::referenceFromDeformed(motion, breath, s.channel_side, deformed_m);
    }
};

// Walks along a path that may cross the cavity surface, where the two sides have slid past each other. The
// reference position jumps there; the tissue in between is not on the path.
void walkAcrossSides(NeedleState& s, SectionSolver& solver, const Course& course, const Vec3& to_m,
                     double travel_m, Direction direction) noexcept {
    // Residual of the inverse breathing motion at the channel point. It is added to every target, so that it
    // never accumulates.
    Vec3 anchor_m = s.channel_reference_m - course.reference(s, course.at_m);
    const auto pointAt = [&](double share) { return course.at_m + share * (to_m - course.at_m); };
    const auto jump = [&](double share, patient::Side side) {
        s.channel_side = side;
        s.channel_reference_m = course.reference(s, pointAt(share));
        anchor_m = Vec3(0.0);
    };
    const patient::SideChanges changes =
        patient::sideChanges(course.motion, course.breath, course.at_m, to_m);
    // Breathing may have moved the cavity surface past the channel point.
    if (changes.first != s.channel_side) jump(0.0, changes.first);
    patient::forEachStretch(changes, [&](double begin, double end) {
        if (begin > 0.0)
            jump(begin,
                 s.channel_side == patient::Side::inside ? patient::Side::outside : patient::Side::inside);
        walk(s, solver, course.patient.grid(), anchor_m + course.reference(s, pointAt(end)),
             travel_m * (end - begin), direction);
    });
}

void walk(NeedleState& s, SectionSolver& solver, Course& course, const Vec3& to_m, double travel_m,
          Direction direction) noexcept {
    const Vec3 step_m = to_m - course.at_m;
    if (isStraightPath(s, step_m)) {
        const Vec3 to_reference_m = s.channel_reference_m + s.channel_motion.reference_from_deformed * step_m;
        walk(s, solver, course.patient.grid(), to_reference_m, travel_m, direction);
    } else {
        walkAcrossSides(s, solver, course, to_m, travel_m, direction);
    }
    course.at_m = to_m;
}

// Outside the body the channel is at the tip.
void followTip(NeedleState& s, const Course& course, const Vec3& tip_deformed_m) noexcept {
    const Vec3 step_m = tip_deformed_m - course.at_m;
    if (isStraightPath(s, step_m)) {
        s.channel_reference_m += s.channel_motion.reference_from_deformed * step_m;
    } else {
        placeChannel(s, course.motion, course.breath, tip_deformed_m);
    }
    s.lateral_m = Vec3(0.0);
}

// A fold of skin follows a shaft this far.
constexpr double kFoldFollows_m = 0.003;

// True if the shaft of a needle outside the body is beside the place where it last left the skin: it no
// longer passes through the folds there. It cannot go back along itself without passing through them.
bool hasLeftFolds(const NeedleState& s, const BreathingPatient& now, const NeedleShaft& shaft) noexcept {
    const Vec3 fold_m = patient::deformedFromReference(now.motion(), now.breath, s.fold_reference_m);
    const Vec3 from_tip = fold_m - shaft.tip_m;
    return glm::length(from_tip - glm::dot(from_tip, shaft.axis) * shaft.axis) > kFoldFollows_m;
}

// Energy of tenting one border. Against bone the force, and with it the slope of the energy, is limited to
// the model's maximum.
double tentingEnergy(const TentingBorder& h, const NeedleSettings& settings,
                     const Patient& patient) noexcept {
    if (h.depth_m <= 0.0) return 0.0;
    const patient::TissueRow& row = patient.row(h.border.to);
    const TentingCurve curve = tentingCurve(row, h.a0_n, settings.a1_share);
    if (!isRigid(row)) return curve.energy_j(h.depth_m);
    const double max_n = std::max(settings.max_force_n, h.a0_n);
    const double rise_m = std::min(h.depth_m, (max_n - h.a0_n) / row.stiffness_n_per_m);
    return curve.energy_j(rise_m) + max_n * (h.depth_m - rise_m);
}

// True if an event makes the force step. The force is continuous when a border starts tenting.
bool hasForceStep(const NeedleEvents& events) noexcept {
    const std::span<const NeedleEvent> all = events.all();
    return events.dropped > 0 || std::any_of(all.begin(), all.end(), [](const NeedleEvent& e) {
               return e.kind != NeedleEventKind::border;
           });
}

}  // namespace

ToolForce stepNeedle(NeedleState& s, const NeedleSettings& settings, const BreathingPatient& now,
                     const NeedleShaft& shaft, NeedleEvents& events, const Incisions& incisions) noexcept {
    const Patient& patient = now.patient;
    const Surrogate& breath = now.breath;
    const auto& [tip_deformed_m, axis] = shaft;
    events.count = events.dropped = 0;
    if (!s.primed) prime(s, patient, tip_deformed_m, breath);
    if (s.phase == Phase::outside && s.fold_count > 0 && hasLeftFolds(s, now, shaft)) s.fold_count = 0;

    const patient::MotionModel& motion = patient.package().motion;
    Course course{patient, motion, breath,
                  patient::follow(s.channel_motion, motion, breath, s.channel_side, s.channel_reference_m)};
    ToolForce out;
    if (s.phase != Phase::outside && !(breath == s.breath))
        out.tissue_moved_m = course.at_m - (s.tip_deformed_m - s.lateral_m);
    const Vec3 offset = tip_deformed_m - course.at_m;
    // Motion relative to the channel, not to the last stylus position. The two differ if the shaft turns
    // while the tip is displaced sideways from the channel.
    const double ds = glm::dot(offset, axis);
    const Direction along = ds > 0.0 ? Direction::advance : Direction::withdraw;
    SectionSolver solver(s, settings, patient, events, incisions,
                         s.channel_motion.reference_from_deformed * axis);

    if (s.phase == Phase::outside) {
        walk(s, solver, course, tip_deformed_m, ds, along);
    } else {
        // The channel moves with breathing; the tip moves in it along the axis.
        const Vec3 across = offset - ds * axis;
        walk(s, solver, course, tip_deformed_m - across, ds, along);
        s.lateral_m = across;
        const double length = glm::length(across);
        const double k = settings.lateral_stiffness_n_per_m;
        const double reach = k > 0.0 ? settings.lateral_force_n / k : 0.0;  // beyond it: cuts sideways
        if (s.phase != Phase::outside && length > reach) {
            s.lateral_cut_m += length - reach;
            s.lateral_m = across * (reach / length);
            walk(s, solver, course, tip_deformed_m - s.lateral_m, 0.0, Direction::sideways);
        }
    }
    if (s.phase == Phase::outside) {
        followTip(s, course, tip_deformed_m);
        if (solver.hasLeft()) s.fold_reference_m = s.channel_reference_m;
    }
    s.tip_deformed_m = tip_deformed_m;
    s.breath = breath;
    s.force_n = solver.force();

    out.force_n = needleForce(s, settings, axis);
    out.energy_j = axialEnergy(s, settings, patient) +
                   0.5 * settings.lateral_stiffness_n_per_m * glm::dot(s.lateral_m, s.lateral_m);
    out.event = solver.hasLeft() || hasForceStep(events);
    return out;
}

NeedleEvent drawOutNeedle(NeedleState& s) noexcept {
    NeedleEvent event{.kind = NeedleEventKind::withdrawn,
                      .border = {s.channel_reference_m, s.tissue, Tissue::air, 0, s.depth_m},
                      .force_before_n = s.force_n};
    endTrack(s);
    s.fold_count = 0;
    s.force_n = 0.0;
    s.lateral_m = Vec3(0.0);
    return event;
}

Vec3 needleForce(const NeedleState& s, const NeedleSettings& settings, const Vec3& axis) noexcept {
    return -s.force_n * axis - settings.lateral_stiffness_n_per_m * s.lateral_m;
}

double axialEnergy(const NeedleState& s, const NeedleSettings& settings, const Patient& patient) noexcept {
    if (s.phase == Phase::outside) return 0.0;
    double energy_j = 0.5 * patient.row(s.tissue).stiffness_n_per_m * s.extension_m * s.extension_m;
    if (s.phase == Phase::tenting) energy_j += tentingEnergy(s.tenting, settings, patient);
    if (s.bone_over_tenting) energy_j += tentingEnergy(s.under_bone, settings, patient);
    return energy_j;
}

double proxyDistance(const NeedleState& s) noexcept {
    return s.phase == Phase::tenting && s.tenting.depth_m >= 0.0 ? s.tenting.depth_m : s.extension_m;
}

namespace {

void hashBorder(StateHash& hash, const Border& b) noexcept {
    hash.add(b.reference_m,
             std::uint64_t(b.from) | std::uint64_t(b.to) << 8 | std::uint64_t(b.to_label) << 16, b.depth_m);
}

void hashTenting(StateHash& hash, const TentingBorder& h) noexcept {
    hashBorder(hash, h.border);
    hash.add(h.depth_m, h.a0_n);
}

}  // namespace

void hashNeedle(StateHash& hash, const NeedleState& s) noexcept {
    hash.add(std::uint64_t(s.phase) | std::uint64_t(s.tissue) << 8 | std::uint64_t(s.label) << 16 |
             std::uint64_t(s.track.past_skin) << 24 | std::uint64_t(s.track.past_fascia) << 25 |
             std::uint64_t(s.bone_over_tenting) << 26 | std::uint64_t(s.primed) << 27 |
             std::uint64_t(s.channel_side) << 28 | std::uint64_t(s.channel_motion.side) << 29);
    hash.add(s.extension_m, s.force_n, s.depth_m, s.past_skin_depth_m, s.past_fascia_depth_m);
    if (s.phase == Phase::tenting) hashTenting(hash, s.tenting);
    if (s.bone_over_tenting) hashTenting(hash, s.under_bone);
    hash.add(std::uint64_t(s.queued_count) | std::uint64_t(s.fold_count) << 32);
    if (s.fold_count > 0) hash.add(s.fold_reference_m);
    for (int i = 0; i < s.queued_count; ++i)
        hashBorder(hash, s.queued[std::size_t(i)]);
    hash.add(s.cuts.value(), s.lateral_m, s.lateral_cut_m, s.tip_deformed_m, s.channel_reference_m);
    // The local motion is fully determined by these three values.
    hash.add(s.channel_motion.reference_m, s.channel_motion.v, s.channel_motion.rate_per_s);
    patient::hashSurrogate(hash, s.breath);
}

}  // namespace stylet::haptics
