#include "haptics/loop/access.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics/tools/touch.h"

namespace stylet::haptics {

namespace {

constexpr double kShortestTrack_m = 0.005;  // a needle that has only pricked the skin still has a direction
constexpr double kTangent_m = 0.003;        // over which the track's direction at the base is taken
constexpr double kIntoDrain_m = 0.005;      // of a wire that is put into the drain
constexpr double kLongestStep_m = 0.003;    // per tick; a longer step of the hand is a leap
constexpr int kHoleSamples = 8;
constexpr double kPi = 3.14159265358979324;
const patient::DuctSpace kNoDucts;

Vec3 deformedAt(const BreathingPatient& now, const Vec3& reference_m) noexcept {
    return patient::deformedFromReference(now.motion(), now.breath, reference_m);
}

// `rotation` turned by the smallest angle, so that its +z points along `z`.
Quat aligned(const Quat& rotation, const Vec3& z) noexcept {
    const Vec3 from = rotation * Vec3(0.0, 0.0, 1.0), axis = glm::cross(from, z);
    const Quat turn{1.0 + glm::dot(from, z), axis.x, axis.y, axis.z};
    const double norm = std::sqrt(glm::dot(turn, turn));
    if (norm < 1e-9) return rotation;
    return Quat{turn.w / norm, turn.x / norm, turn.y / norm, turn.z / norm} * rotation;
}

// Sets the track to that of the needle.
void beginTrack(AccessState& s, const NeedleState& needle, const Pose& patient_from_needle,
                const BreathingPatient& now) noexcept {
    const auto reference = [&](const Vec3& deformed_m) {
        return patient::referenceFromDeformed(now.motion(), now.breath, deformed_m);
    };
    const Vec3 into = patient_from_needle.direction({0.0, 0.0, -1.0});
    s.base.at_m = needle.channel_reference_m;
    const Vec3 tip_m = deformedAt(now, s.base.at_m);
    s.entry_m = reference(tip_m - std::max(kShortestTrack_m, needle.depth_m) * into);
    s.base.axis = unitOr(s.base.at_m - reference(tip_m - kTangent_m * into), into);
    s.track_m = glm::length(s.base.at_m - s.entry_m);
    s.patient_from_needle = patient_from_needle.rotation;
    s.axis = into;
    s.pending = false;
}

// The way of dilator and drain: the track, then the wire.
void updatePath(AccessState& s) noexcept {
    s.path_m[0] = s.entry_m;
    s.path_m[1] = s.base.at_m;
    s.path_count = 2;
    for (int i = s.wire.count; i-- > 0;)
        s.path_m[std::size_t(s.path_count++)] = s.wire.nodes_m[std::size_t(i)];
}
std::span<const Vec3> points(const AccessState& s) noexcept {
    return std::span(s.path_m).first(std::size_t(s.path_count));
}
TubePath wirePath(const AccessState& s) noexcept {
    const double length_m = pathLength_m(points(s));
    return {points(s), s.wire.fed_m > 0.0 ? length_m : s.track_m + s.wire.fed_m};
}

void closeAccess(AccessState& s) noexcept {
    s.open = s.needle_in = s.wire_in = false;
    s.wire = {};
}

// Once the wire's tip has left the drain's end, the loop forms, or the end springs back in the tissue.
void releaseDrain(AccessState& s, const AccessSettings& settings, const BreathingPatient& now) noexcept {
    const double wire_m = s.track_m + s.wire.fed_m;
    if (wire_m > s.drain.depth_m - kPi * settings.drain.pigtail_m) return;
    const TubePath path{points(s), s.drain.depth_m};
    const auto inDuct = [&](double depth_m) {
        return now.ducts && patient::isInTargetDuct(*now.ducts, pointAt(path, depth_m));
    };
    int holes = 0;
    for (int i = 0; i < kHoleSamples; ++i)
        holes += inDuct(s.drain.depth_m - kSideHoles_m * (i + 0.5) / kHoleSamples);
    s.holes_in_duct = double(holes) / kHoleSamples;
    s.drain_state = inDuct(s.drain.depth_m) ? DrainState::in_place : DrainState::misplaced;
}

// The wire has reached the middle of the loop of a drain that it had left. It need not reach the drain's end:
// where that lies at a wall, the wire may stop a little earlier than the first time.
void straightenDrain(AccessState& s, const AccessSettings& settings) noexcept {
    if (s.track_m + s.wire.fed_m < s.drain.depth_m - 0.5 * kPi * settings.drain.pigtail_m) return;
    s.drain_state = DrainState::over_wire;
    s.holes_in_duct = 0.0;
}

struct AxialForce {
    double force_n = 0.0, energy_j = 0.0;
    bool event = false;
};

AxialForce moveWire(AccessState& s, const AccessSettings& settings, const BreathingPatient& now,
                    double moved_m) noexcept {
    const double force_n =
        stepWire(s.wire, settings.wire, now.ducts ? *now.ducts : kNoDucts, s.base, moved_m);
    const bool inside = s.wire.fed_m > -s.track_m;
    if (s.drain_state == DrainState::over_wire)
        releaseDrain(s, settings, now);
    else if (s.drain_state != DrainState::none)
        straightenDrain(s, settings);
    const bool held = s.needle_in || s.drain_state == DrainState::over_wire;
    const bool lost = !inside && !held;
    if (lost) closeAccess(s);
    return {lost ? 0.0 : force_n, lost ? 0.0 : wireEnergy_j(s.wire, settings.wire), lost};
}

AxialForce moveTube(AccessState& s, const AccessTools& tools, TubeState& tube, const TubeSettings& settings,
                    const BreathingPatient& now, double moved_m) noexcept {
    updatePath(s);
    const TubePath path = wirePath(s);
    const Opening opening{s.dilated_m, s.dilated_to_m, tools.needle.cut_reach_m};
    const patient::Tissue before = tube.tissue;
    const double force_n = stepTube(tube, settings, path, opening, now.patient, moved_m);
    // Behind the taper the track has the tube's diameter.
    const double full_m = tube.depth_m - settings.taper_m;
    if (full_m > s.dilated_m) s.dilated_m = full_m, s.dilated_to_m = settings.outer_m;
    return {force_n, tubeEnergy_j(tube, settings), tube.tissue != before};
}

// A needle that has left the body ends the access, unless the wire stays. Returns true if it has left.
bool leaveWithNeedle(AccessState& s, const NeedleState& needle) noexcept {
    if (needle.phase != Phase::outside) return false;
    s.needle_in = false;
    if (!s.wire_in || s.wire.fed_m <= 0.0) closeAccess(s);
    return true;
}

AxialForce moveNeedle(AccessState& s, NeedleState& needle, const NeedleSettings& settings,
                      const BreathingPatient& now, double moved_m, NeedleEvents& events) noexcept {
    // Over the wire the needle goes back, and forward again to where it was.
    s.needle_at_m += moved_m;
    if (s.wire_in && s.wire.fed_m > 0.0) s.needle_at_m = std::min(s.needle_at_m, 0.0);
    if (!s.needle_in) return {};
    const ToolForce force =
        stepNeedle(needle, settings, now, {s.base_deformed_m + s.needle_at_m * s.axis, s.axis}, events);
    if (leaveWithNeedle(s, needle)) return {0.0, 0.0, true};
    return {needle.force_n, axialEnergy(needle, settings, now.patient), force.event};
}

}  // namespace

std::uint64_t digest(const AccessSettings& settings) noexcept {
    StateHash hash;
    visitAccessNumbers(settings, [&](double v) { hash.add(v); });
    return hash.value();
}

void openAccess(AccessState& s) noexcept {
    s = {};
    s.used = s.open = s.pending = s.needle_in = s.wire_in = true;
}

void openThroughDrain(AccessState& s) noexcept {
    s.open = s.wire_in = true;
    s.wire = {};
    s.wire.fed_m = kIntoDrain_m - s.track_m;
}

void letGo(AccessState& s) noexcept {
    s.released = true;
    s.wire.extension_m = s.dilator.extension_m = s.drain.extension_m = 0.0;
}

void layDownWire(AccessState& s) noexcept {
    if (!s.needle_in || s.wire.fed_m > 0.0) return;
    s.wire = {};
    s.wire_in = false;
}

ToolForce stepAccess(AccessState& s, NeedleState& needle, Pose& patient_from_needle, const AccessTools& tools,
                     const BreathingPatient& now, const Vec3& hand_m, NeedleEvents& events) noexcept {
    if (s.pending) beginTrack(s, needle, patient_from_needle, now);
    const Vec3 base_m = deformedAt(now, s.base.at_m);
    s.axis = unitOr(base_m - deformedAt(now, s.entry_m), s.axis);
    const Vec3 hand_moved_m = s.gripped ? hand_m - s.hand_m : Vec3(0.0);
    const Vec3 tissue_moved_m = s.gripped ? base_m - s.base_deformed_m : Vec3(0.0);
    const double along_m = glm::dot(hand_moved_m - tissue_moved_m, s.axis);
    const bool follows = !s.released && std::fabs(along_m) <= kLongestStep_m;  // false for NaN
    const double moved_m = follows ? along_m : 0.0;
    const bool gripped = s.gripped;
    s.hand_m = hand_m, s.base_deformed_m = base_m, s.gripped = true;

    AxialForce axial;
    switch (tools.in_hand) {
        case OnTrack::needle:
            axial = moveNeedle(s, needle, tools.needle, now, moved_m, events);
            break;
        case OnTrack::wire:
            s.wire_in = true;
            axial = moveWire(s, tools.access, now, moved_m);
            break;
        case OnTrack::dilator:
            axial = moveTube(s, tools, s.dilator, tools.access.dilator, now, moved_m);
            break;
        case OnTrack::drain:
            axial = moveTube(s, tools, s.drain, tools.access.drain, now, moved_m);
            s.drain_state = s.drain.depth_m > 0.0 ? DrainState::over_wire : DrainState::none;
            break;
    }
    if (tools.in_hand != OnTrack::needle && s.needle_in) {  // the assistant's hand: nobody feels its force
        stepNeedle(needle, tools.needle, now, {base_m + s.needle_at_m * s.axis, s.axis}, events);
        leaveWithNeedle(s, needle);
    }
    if (s.needle_in || tools.in_hand == OnTrack::needle)
        patient_from_needle = {aligned(s.patient_from_needle, -s.axis), base_m + s.needle_at_m * s.axis};
    s.force_n = axial.force_n;
    ToolForce force;
    force.event = axial.event || !gripped;
    if (s.released) return force;
    force.force_n = -axial.force_n * s.axis;
    force.tissue_moved_m = tissue_moved_m;
    force.energy_j = axial.energy_j;
    return force;
}

void summarize(const AccessState& s, const patient::DuctSpace* ducts, AccessOutput& out) noexcept {
    static_cast<AccessStatus&>(out) = {};
    if (!s.used) return;
    out.open = s.open, out.needle_in = s.needle_in, out.wire_in = s.wire_in;
    out.drain = s.drain_state;
    out.dilator_m = s.dilator.depth_m, out.drain_m = s.drain.depth_m;
    out.dilated_m = s.dilated_m, out.holes_in_duct = s.holes_in_duct;
    out.entry_m = s.entry_m, out.base_m = s.base.at_m;
    out.path_count = s.path_count;
    for (int i = 0; i < s.path_count; ++i)
        out.path_m[std::size_t(i)] = glm::vec3(s.path_m[std::size_t(i)]);
    if (!s.wire_in) return;
    out.buckled = s.wire.buckled;
    out.pierced = s.wire.fed_m >= s.wire.pierced_m;
    out.wire_m = s.wire.fed_m;
    out.wire_tip_m = wireTip(s.wire, s.base);
    out.tip_in_duct =
        s.wire.in_lumen && !out.pierced && ducts && patient::isInTargetDuct(*ducts, out.wire_tip_m);
    out.in_duct_m = out.tip_in_duct ? s.wire.fed_m - s.wire.solid_m : 0.0;
    out.node_count = s.wire.count;
    for (int i = 0; i < s.wire.count; ++i)
        out.nodes_m[std::size_t(i)] = glm::vec3(s.wire.nodes_m[std::size_t(i)]);
}

void hashAccess(StateHash& hash, const AccessState& s, const NeedleState& needle) noexcept {
    hash.add(std::uint64_t(s.open) | std::uint64_t(s.pending) << 1 | std::uint64_t(s.needle_in) << 2 |
             std::uint64_t(s.wire_in) << 3 | std::uint64_t(s.gripped) << 4 | std::uint64_t(s.released) << 5 |
             std::uint64_t(s.drain_state) << 8 | std::uint64_t(s.path_count) << 16);
    hash.add(s.entry_m, s.base.at_m, s.base.axis, s.track_m, s.needle_at_m, s.patient_from_needle);
    hash.add(s.dilated_m, s.dilated_to_m, s.holes_in_duct, s.hand_m, s.base_deformed_m, s.axis, s.force_n);
    hashWire(hash, s.wire);
    hashTube(hash, s.dilator);
    hashTube(hash, s.drain);
    for (const Vec3& point_m : points(s))
        hash.add(point_m);
    if (s.needle_in) hashNeedle(hash, needle);
}

}  // namespace stylet::haptics
