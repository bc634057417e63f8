#include "app/training/evidence.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "app/training/drain_end.h"

namespace stylet::training {

using haptics::TickOutput;
using haptics::Tool;
using patient::Tissue;

namespace {

constexpr double kCheckInterval_s = 0.02;  // interval of the finger and probe checks
// Palpation: the press must be firmer than a touch (a gap gives 0.03 N/mm) and last long enough to feel.
constexpr double kPressed_n = 0.05, kMinGapPress_s = 0.2, kMinRibPress_s = 0.1;
constexpr double kSpaceReach_m = 0.040;  // greatest distance from the entry, along and across the ribs
// A rib further from the entry is not asked for: on a curved flank a finger loses the skin on the way.
constexpr double kRibReach_m = 0.030;
constexpr double kRibDepth_m = 0.040;  // greatest depth of a rib under the skin
constexpr double kBeforeSkin_m = 0.005;
constexpr double kSkinSearch_m = 0.030;  // before and behind the entry's plane
constexpr double kSample_m = 0.001, kAside_m = 0.003;
// Ultrasound: distance of the duct from the picture's plane, and the time for which it must be visible.
constexpr double kDuctInPlane_m = 0.004, kMinVisible_s = 1.0;
// The guide's line meets the duct if at least this length of it lies in the duct, near the target.
constexpr double kMinChord_m = 0.0015, kChordReach_m = 0.010, kChordSample_m = 0.0005;
constexpr double kAtEntry_m = 0.005, kMinIncision_m = 0.003, kMaxIncision_m = 0.015;
constexpr double kOnRail_m = 0.002;     // depth in the body that the needle reaches on the rail
constexpr double kMissed_m = 0.010;     // distance of the tip past the target, along the path
constexpr double kMinSeen = 0.5;        // share of the insertion in the beam
constexpr double kHalfBeam_m = 0.0025;  // half the thickness of the ultrasound beam
// Length of the wire in the duct: the drain's side holes follow it.
constexpr double kMinWire_m = haptics::kSideHoles_m;
constexpr double kTorn_m = 0.003;  // of the track in one insertion of the drain
// Of DrainEnd::kHoles. The ducts' borders are known to a voxel or two.
constexpr int kMaxHolesAside = 3;
constexpr double kShownContrast_m3 = 2e-7, kAstrayContrast_m3 = 1e-6;

double distanceToSegment_m(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 ab = b - a;
    const double length2 = glm::dot(ab, ab);
    const double share = length2 > 0.0 ? std::clamp(glm::dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
    return glm::length(p - a - ab * share);
}

// Pose of the probe that makes the picture: the parked one, or the one in the hand if it touches.
std::optional<Pose> picturingProbe(const TickOutput& now, double min_contact) noexcept {
    if (now.probe_parked) return now.patient_from_probe;
    if (now.tool != Tool::probe || !(now.probe_touching_share > min_contact)) return std::nullopt;
    return now.patient_from_tool * haptics::kStylusFromProbe;
}

// At the depths at which a finger can feel a rib, along the path's direction.
bool isOverBone(const patient::Patient& patient, const Vec3& reference_m, const Vec3& axis) noexcept {
    for (double at_m = -kBeforeSkin_m; at_m <= kRibDepth_m; at_m += kSample_m)
        if (isSkeleton(patient.at(reference_m + axis * at_m, {true, false}).tissue)) return true;
    return false;
}

Vec3 pathAxis(const patient::PlannedPath& path) noexcept {
    const Vec3 inward_m = path.target_reference_m - path.entry_reference_m;
    return glm::length(inward_m) > 0.0 ? glm::normalize(inward_m) : Vec3(0.0, 0.0, 1.0);
}

}  // namespace

std::optional<Vec3> skinOverRib(const patient::Patient& patient, const patient::PlannedPath& path,
                                double toward_head) {
    const Vec3 axis = pathAxis(path), head(0.0, 0.0, 1.0), across = head - axis * glm::dot(head, axis);
    if (!(glm::length(across) > 0.1)) return std::nullopt;  // the path runs along the body
    const Vec3 step_m = glm::normalize(across) * (toward_head * kAside_m);
    const auto isOver = [&](int n) {
        return isOverBone(patient, path.entry_reference_m + step_m * double(n), axis);
    };
    int first = 1;
    while (first * kAside_m <= kRibReach_m && !isOver(first))
        ++first;
    if (!(first * kAside_m <= kRibReach_m)) return std::nullopt;
    int last = first;
    while ((last + 1) * kAside_m <= kSpaceReach_m && isOver(last + 1))
        ++last;
    const Vec3 middle_m = path.entry_reference_m + step_m * (0.5 * (first + last));
    for (double at_m = -kSkinSearch_m; at_m < kSkinSearch_m; at_m += kSample_m)
        if (patient.at(middle_m + axis * at_m, {true, false}).tissue != Tissue::air)
            return middle_m + axis * at_m;
    return middle_m;
}

double shareInBeam(const TickOutput& now) noexcept {
    const std::optional<Pose> patient_from_probe = picturingProbe(now, 0.0);
    if (!patient_from_probe) return 0.0;
    const Pose probe_from_needle = patient_from_probe->inverse() * now.patient_from_needle;
    const double tip = probe_from_needle.position_m.y;
    const double skin = (probe_from_needle * Vec3(0.0, 0.0, std::max(now.depth_m, 0.0))).y;
    const double low = std::min(tip, skin), high = std::max(tip, skin);
    if (high - low < 1e-6) return std::fabs(tip) <= kHalfBeam_m ? 1.0 : 0.0;
    return std::clamp((std::min(high, kHalfBeam_m) - std::max(low, -kHalfBeam_m)) / (high - low), 0.0, 1.0);
}

Evidence::Evidence(const patient::Patient& patient, const patient::PlannedPath& path, double dt_s)
    : patient_(&patient),
      path_(path),
      dt_s_(dt_s),
      infiltration_(patient, path),
      axis_reference_(pathAxis(path)),
      check_interval_ticks_(std::uint64_t(std::max(1.0, std::floor(kCheckInterval_s / dt_s + 0.5)))) {
    needs_headward_ = skinOverRib(patient, path, 1.0).has_value();
    needs_footward_ = skinOverRib(patient, path, -1.0).has_value();
}

std::uint32_t Evidence::update(const TickOutput& now, const TickFacts& facts, const AttemptFold& fold) {
    if (tick_count_ == 0) previous_ = now;
    if (tick_count_++ % check_interval_ticks_ == 0) {
        if (!has(Step::findGap)) palpate(now);
        if (!has(Step::findDuct)) look(now, facts.path.target_m, fold.equipment().ultrasound);
        if (!has(Step::advance)) aim(now, facts.path.target_m);
        const bool straight = now.access.drain == haptics::DrainState::over_wire;
        holes_ = course_ == Course::drainage && straight ? judgeHoles(now.access) : Refusal::none;
    }
    // The tool is put down, or the probe is parked: the step was tried.
    const bool put_down = previous_.tool == Tool::finger && now.tool != Tool::finger;
    if (put_down && !has(Step::findGap)) refusal_ = missing(Step::findGap);
    if (now.probe_parked && !previous_.probe_parked && !has(Step::findDuct))
        refusal_ = missing(Step::findDuct);
    if (!has(Step::incise)) judgeIncision(now);
    followInsertion(now, facts);
    if (!has(Step::advance)) judgePuncture(now, facts, fold.equipment().ultrasound);
    // A wire that is passed through the drain again needs no new proof.
    if (previous_.access.open && !now.access.open) drain_proven_ = proven_;
    if (!previous_.access.open && now.access.open && now.access.drain != haptics::DrainState::none)
        proven_ = drain_proven_;
    if (!facts.inside && !now.access.open) {
        proven_ = refused_wire_ = false;
        ducts_at_entry_m3_ = fold.contrast().volumes().ducts_m3;
    }
    judgeContrast(now, fold);
    if (course_ == Course::drainage) {
        judgeAnaesthesia(now, fold);
        judgeAspiration(fold, facts.infiltrates);
        judgeDrainage(now, facts.torn_m);
    }
    previous_ = now;
    return found_;
}

Refusal Evidence::missing(Step step) const noexcept {
    if (has(step)) return Refusal::none;
    if (step == Step::findGap)
        return gap_s_ < kMinGapPress_s                           ? Refusal::gapNotFelt
               : needs_headward_ && headward_s_ < kMinRibPress_s ? Refusal::upperRibNotFelt
                                                                 : Refusal::lowerRibNotFelt;
    if (step == Step::anaesthetise)
        return aimed_ || (infiltration_.begun() && previous_.probe_parked) ||
                       infiltration_.place() != TrackPlace::outside
                   ? infiltration_.missing()
                   : Refusal::ductBesideRail;
    if (step == Step::advance && refused_puncture_ != Refusal::none) return refused_puncture_;
    if (step == Step::wire && !proven_) return Refusal::wireUnproven;
    if (step == Step::drain) return holes_;
    if (step == Step::incise || step == Step::guide || step == Step::advance)
        return aimed_ ? Refusal::none : Refusal::ductBesideRail;
    if (step != Step::findDuct) return Refusal::none;
    switch (view_) {
        case View::noContact:
            return Refusal::noContact;
        case View::besidePlane:
            return Refusal::ductBesidePlane;
        case View::outsideSector:
            return Refusal::ductOutsidePicture;
        case View::shadowed:
            return Refusal::ductShadowed;
        case View::shown:
            break;
    }
    return Refusal::ductTooShort;
}

// What lies under a place on the skin: the path's intercostal space if there is no bone on the way to the
// entry, a rib beside that space if all bone on the way is at this end of it.
Evidence::Beneath Evidence::findBeneath(const Vec3& reference_m) const noexcept {
    const Vec3 to_entry_m = path_.entry_reference_m - reference_m;
    const double length_m = glm::length(to_entry_m);
    if (!(length_m <= kSpaceReach_m)) return Beneath::nothing;
    const auto isOverBone = [&](const Vec3& at_m) {
        return training::isOverBone(*patient_, at_m, axis_reference_);
    };
    const bool rib = isOverBone(reference_m);
    bool on_bone = rib;
    const int pieces = std::max(1, int(std::ceil(length_m / kAside_m)));
    for (int i = 1; i < pieces; ++i) {
        const bool bone = isOverBone(reference_m + to_entry_m * (double(i) / pieces));
        if (bone && !on_bone) return Beneath::nothing;  // a rib lies between
        on_bone = bone;
    }
    if (on_bone) return Beneath::nothing;
    if (!rib) return Beneath::gap;
    return to_entry_m.z < 0.0 ? Beneath::headwardRib : Beneath::footwardRib;
}

void Evidence::palpate(const TickOutput& now) {
    if (now.tool != Tool::finger || !(glm::length(now.tool_force.force_n) > kPressed_n)) return;
    const double looked_s = double(check_interval_ticks_) * dt_s_;
    const Vec3 at_m = patient::referenceFromDeformed(patient_->package().motion, now.breath,
                                                     now.patient_from_tool.position_m);
    switch (findBeneath(at_m)) {
        case Beneath::gap:
            gap_s_ += looked_s;
            break;
        case Beneath::headwardRib:
            headward_s_ += looked_s;
            break;
        case Beneath::footwardRib:
            footward_s_ += looked_s;
            break;
        case Beneath::nothing:
            break;
    }
    if (gap_s_ >= kMinGapPress_s && (!needs_headward_ || headward_s_ >= kMinRibPress_s) &&
        (!needs_footward_ || footward_s_ >= kMinRibPress_s))
        find(Step::findGap);
}

void Evidence::look(const TickOutput& now, const Vec3& target_m, const UltrasoundState& machine) {
    view_ = findView(now, target_m, machine);
    shown_s_ = view_ == View::shown ? shown_s_ + double(check_interval_ticks_) * dt_s_ : 0.0;
    if (shown_s_ >= kMinVisible_s) find(Step::findDuct);
}

// Gain and focus do not matter here: they are the machine's, not the hand's.
View Evidence::findView(const TickOutput& now, const Vec3& target_m,
                        const UltrasoundState& machine) const noexcept {
    const std::optional<Pose> patient_from_probe = picturingProbe(now, kMinContact);
    if (!patient_from_probe) return View::noContact;
    const Vec3 p = patient_from_probe->inverse() * target_m;
    if (!(std::fabs(p.y) <= kDuctInPlane_m)) return View::besidePlane;
    if (!(p.z > 0.0)) return View::outsideSector;
    const std::optional<Vec3> from = haptics::scanLineStart(tools_.probe, p);
    if (!from) return View::outsideSector;
    const double length_m = glm::length(p - *from);
    if (!(length_m <= machine.depth_m)) return View::outsideSector;
    const patient::MotionModel& motion = patient_->package().motion;
    bool in_body = false;
    for (double at_m = 0.0; at_m < length_m; at_m += kSample_m) {
        const Vec3 at = *patient_from_probe * glm::mix(*from, p, at_m / length_m);
        const Tissue tissue =
            patient_->at(patient::referenceFromDeformed(motion, now.breath, at), {true, false}).tissue;
        if (isSkeleton(tissue) || (in_body && tissue == Tissue::air)) return View::shadowed;
        in_body = in_body || (tissue != Tissue::air && at_m > kBeforeSkin_m);
    }
    return View::shown;
}

// A needle in the guide stays on the guide's line. While the patient breathes, the duct passes that line.
void Evidence::aim(const TickOutput& now, const Vec3& target_m) noexcept {
    const std::optional<Pose> patient_from_probe = picturingProbe(now, kMinContact);
    // After the probe was lifted, its new place must be aimed.
    if (!patient_from_probe) aimed_ = false;
    if (!patient_from_probe || !now.breath_held) return;
    const Pose patient_from_rail = *patient_from_probe * tools_.guide.probe_from_guide;
    const double nearest_m = (patient_from_rail.inverse() * target_m).z;
    double chord_m = 0.0;
    for (double at_m = -kChordReach_m; at_m <= kChordReach_m; at_m += kChordSample_m) {
        const Vec3 at = patient::referenceFromDeformed(patient_->package().motion, now.breath,
                                                       patient_from_rail * Vec3(0.0, 0.0, nearest_m + at_m));
        const patient::Label* label = patient_->label(patient_->at(at, {true, false}).label);
        if (label && label->tissue == Tissue::duct && label->role == patient::Role::target)
            chord_m += kChordSample_m;
    }
    // A parked probe stays aimed until the line misses the duct, although the breath-hold drifts.
    aimed_ = chord_m >= (aimed_ && now.probe_parked ? kChordSample_m : kMinChord_m);
}

bool Evidence::isAtEntry(const haptics::Incision& cut, const TickOutput& now) const noexcept {
    if (distanceToSegment_m(path_.entry_reference_m, cut.begin_reference_m, cut.end_reference_m) <=
        kAtEntry_m)
        return true;
    if (!now.probe_parked) return false;
    // The rail's line passes the cut, seen along the rail.
    const patient::MotionModel& motion = patient_->package().motion;
    const Pose rail_from_patient = (now.patient_from_probe * tools_.guide.probe_from_guide).inverse();
    const auto acrossRail = [&](const Vec3& reference_m) {
        const Vec3 p = rail_from_patient * patient::deformedFromReference(motion, now.breath, reference_m);
        return Vec3(p.x, p.y, 0.0);
    };
    return distanceToSegment_m(Vec3(0.0), acrossRail(cut.begin_reference_m),
                               acrossRail(cut.end_reference_m)) <= kAtEntry_m;
}

void Evidence::judgeIncision(const TickOutput& now) {
    if (now.cut_incision >= 0 || previous_.cut_incision < 0) return;
    // The blade has just left the skin.
    const haptics::Incision& cut = previous_.cut;
    const double length_m = glm::length(cut.end_reference_m - cut.begin_reference_m);
    if (!isAtEntry(cut, now))
        refusal_ = Refusal::incisionAside;
    else if (length_m < kMinIncision_m)
        refusal_ = Refusal::incisionTooShort;
    else if (length_m > kMaxIncision_m) {
        refusal_ = Refusal::incisionTooLong;
        spoiled_incision_ = true;
    } else
        find(Step::incise);
}

void Evidence::followInsertion(const TickOutput& now, const TickFacts& facts) {
    if (!facts.inside) {
        travel_m_ = seen_m_ = 0.0;
        on_rail_ = beside_rail_ = false;
        refused_puncture_ = Refusal::none;
        anchor_m_ = now.tip_reference_m;
        return;
    }
    const bool guided = now.needle_in_guide && now.probe_parked;
    if (previous_.phase == haptics::Phase::outside) {
        on_rail_ = guided;
        anchor_m_ = now.tip_reference_m;
    }
    on_rail_ = on_rail_ && guided;
    if (now.depth_m >= kOnRail_m) {
        if (on_rail_)
            find(Step::guide);
        else if (!facts.infiltrates && !has(Step::guide) && !std::exchange(beside_rail_, true))
            refusal_ = Refusal::needleNotInGuide;
    }
    // Motion of the patient does not count as motion of the needle.
    if (now.patient_moved_m != previous_.patient_moved_m) anchor_m_ = now.tip_reference_m;
    const double moved_m = glm::length(now.tip_reference_m - anchor_m_);
    if (!(moved_m >= kMinMotion_m)) return;
    travel_m_ += moved_m;
    seen_m_ += moved_m * facts.in_beam;
    anchor_m_ = now.tip_reference_m;
}

void Evidence::judgePuncture(const TickOutput& now, const TickFacts& facts, const UltrasoundState& machine) {
    if (refused_puncture_ != Refusal::none) return;
    if (facts.inside && !facts.in_target && facts.past_target_m > kMissed_m) {
        refusal_ = refused_puncture_ = Refusal::ductMissed;
        aimed_ = false;  // a line that only grazes the duct no longer counts, although the probe is parked
        return;
    }
    if (!facts.target_cut || !facts.in_target) return;
    const bool needle_seen = travel_m_ > 0.0 && seen_m_ >= kMinSeen * travel_m_;
    refused_puncture_ = !needle_seen                                                 ? Refusal::needleNotSeen
                        : !now.breath_held                                           ? Refusal::breathNotHeld
                        : findView(now, facts.path.target_m, machine) != View::shown ? Refusal::ductNotSeen
                                                                                     : Refusal::none;
    if (refused_puncture_ == Refusal::none)
        find(Step::advance);
    else
        refusal_ = refused_puncture_;
}

void Evidence::judgeAnaesthesia(const TickOutput& now, const AttemptFold& fold) {
    infiltration_.update(now, fold, tools_.guide);
    if (infiltration_.done()) find(Step::anaesthetise);
    if (const Refusal why = infiltration_.popRefusal(); why != Refusal::none) refusal_ = why;
}

void Evidence::judgeAspiration(const AttemptFold& fold, bool infiltrates) {
    if (std::exchange(draws_, fold.aspiration().count) == fold.aspiration().count) return;
    if (infiltrates) return;  // drawn before local anaesthetic is injected: no search for bile
    if (fold.aspiration().drawn == Drawn::bile) {
        find(Step::aspirate);
        proven_ = true;
    } else if (!has(Step::aspirate))
        refusal_ = fold.aspiration().drawn == Drawn::blood ? Refusal::bloodDrawn
                   : previous_.access.wire_in              ? Refusal::wireInNeedle
                                                           : Refusal::noBile;
}

// A step counts as tried when its tool is put down, or the drain curls.
void Evidence::judgeDrainage(const TickOutput& now, double torn_m) {
    const haptics::AccessOutput& access = now.access;
    if (access.needle_in && access.wire_in && !proven_ && !std::exchange(refused_wire_, true))
        refusal_ = Refusal::wireUnproven;
    const auto putDown = [&](Tool tool) { return previous_.tool == tool && now.tool != tool; };
    if (!has(Step::wire)) {
        if (access.wire_in && access.in_duct_m >= kMinWire_m && !access.pierced)
            find(Step::wire);
        else if (putDown(Tool::wire))
            refusal_ = access.pierced ? Refusal::wirePierced : Refusal::wireNotInDuct;
    }
    if (!has(Step::dilate)) {
        if (access.wire_in && access.in_duct_m > 0.0 &&
            access.dilator_m >= glm::length(access.base_m - access.entry_m))
            find(Step::dilate);
        else if (putDown(Tool::dilator))
            refusal_ = Refusal::notDilated;
    }
    judgeDrain(access, torn_m);
}

void Evidence::judgeDrain(const haptics::AccessOutput& access, double torn_m) {
    using haptics::DrainState;
    if (!(access.drain_m > 0.0)) torn_m_ = torn_m;
    if (torn_m > torn_m_ + kTorn_m) {
        torn_m_ = std::numeric_limits<double>::infinity();  // once in each insertion of the drain
        refusal_ = Refusal::trackTorn;
    }
    if (access.drain == previous_.access.drain) return;
    if (access.drain == DrainState::misplaced) refusal_ = Refusal::drainMisplaced;
    if (access.drain != DrainState::in_place) {
        lose(Step::drain);
        lose(Step::finalPicture);
        return;
    }
    // The end lies in a duct. Behind it the loop has its side holes.
    const Refusal leak = judgeHoles(access);
    if (leak == Refusal::none)
        find(Step::drain);
    else
        refusal_ = leak;
}

// The drain is too deep if most of the holes outside the ducts are near its tip.
Refusal Evidence::judgeHoles(const haptics::AccessOutput& access) const noexcept {
    if (access.path_count < 2) return Refusal::drainLeaks;
    const DrainEnd end(access);
    const double radius_m = 0.5 * tools_.access.drain.outer_m;
    int aside = 0, aside_near_tip = 0;
    for (int i = 0; i < DrainEnd::kHoles; ++i) {
        const bool open = end.opening(*patient_, i, radius_m).has_value();
        aside += open ? 0 : 1;
        aside_near_tip += open || 2 * i > DrainEnd::kHoles ? 0 : 1;
    }
    if (aside <= kMaxHolesAside) return Refusal::none;
    return 2 * aside_near_tip > aside ? Refusal::drainTooDeep : Refusal::drainLeaks;
}

void Evidence::judgeContrast(const TickOutput& now, const AttemptFold& fold) {
    const bool curled = now.access.drain == haptics::DrainState::in_place;
    if (!curled) ducts_at_curl_m3_ = fold.contrast().volumes().ducts_m3;
    const std::uint64_t pulses = fold.dose().pulses;
    if (std::exchange(pulses_, pulses) == pulses) return;
    const double in_ducts_m3 = fold.contrast().volumes().ducts_m3;
    proven_ = proven_ || in_ducts_m3 - ducts_at_entry_m3_ >= kShownContrast_m3;
    if (curled) {
        if (in_ducts_m3 - ducts_at_curl_m3_ >= kShownContrast_m3) find(Step::finalPicture);
    } else if (now.access.drain == haptics::DrainState::none && in_ducts_m3 >= kShownContrast_m3)
        find(Step::contrast);  // through the needle
    else if (!has(Step::contrast) && fold.dose().contrast_m3 >= kAstrayContrast_m3 &&
             !std::exchange(refused_contrast_, true))
        refusal_ = Refusal::contrastAstray;
}

}  // namespace stylet::training
