#include "app/training/procedure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "base/text.h"

namespace stylet::training {

using haptics::NeedleEvent;
using haptics::NeedleEventKind;
using haptics::TickOutput;
using haptics::Tool;
using patient::Label;
using patient::MotionModel;
using patient::Role;
using patient::Tissue;

namespace {

constexpr double kCheckInterval_s = 0.02;  // interval of the finger and probe checks
// Palpation: the press must be firmer than a touch (a gap gives 0.03 N/mm) and last long enough to feel the
// gap.
constexpr double kPressed_n = 0.05, kMinPress_s = 0.2;
constexpr double kSpaceReach_m = 0.040;  // greatest distance along the intercostal space
constexpr double kRibDepth_m = 0.040;    // greatest depth of a rib under the skin
constexpr double kBeforeSkin_m = 0.005;
constexpr double kSample_m = 0.001, kAside_m = 0.003;
// Ultrasound: distance of the duct from the picture's plane, and the time for which it must be visible. Probe
// shapes as in assets/ultrasound.
constexpr double kDuctInPlane_m = 0.004, kMinVisible_s = 0.2;
constexpr double kConvexRadius_m = 0.060, kConvexHalfAngle_rad = 0.523599, kLinearHalfWidth_m = 0.020;
constexpr double kAtEntry_m = 0.008;        // greatest distance from an incision to the path's entry
constexpr double kShownContrast_m3 = 2e-7;  // amount in the ducts that is visible in a picture
constexpr double kGasDepth_m = 0.005;       // air closer to the skin is a voxel artefact at a slanted surface
constexpr std::array<std::string_view, std::size_t(kStepCount) + 1> kStepNames{
    "find the space between the ribs",
    "find the duct",
    "open the skin",
    "snap the needle into the guide",
    "advance to the duct",
    "show the ducts with contrast",
    "done"};
constexpr std::array<std::string_view, kRiskStructureCount> kRiskStructureNames{
    "nothing", "bone", "vessel", "lung or gas", "another organ"};

std::string inMm(fmt::format_string<double> format, double metres) {
    return fmt::format(format, metres * 1e3);
}

patient::Side sideOfReference(const MotionModel& motion, const Vec3& reference_m) {
    return patient::cavityLevel_m(motion, reference_m) < 0.0 ? patient::Side::inside : patient::Side::outside;
}

double distanceToSegment_m(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 way = b - a;
    const double length2 = glm::dot(way, way);
    const double share = length2 > 0.0 ? std::clamp(glm::dot(p - a, way) / length2, 0.0, 1.0) : 0.0;
    return glm::length(p - a - way * share);
}

RiskStructure classifyRisk(Tissue tissue) {
    if (tissue == Tissue::bone) return RiskStructure::bone;
    if (tissue == Tissue::vessel) return RiskStructure::vessel;
    return tissue == Tissue::air ? RiskStructure::lung : RiskStructure::otherOrgan;
}

}  // namespace

std::string_view stepName(Step step) noexcept {
    return enumName(kStepNames, step);
}

std::string_view riskStructureName(RiskStructure structure) noexcept {
    return enumName(kRiskStructureNames, structure);
}

Procedure::Procedure(const patient::Patient& patient, const patient::PlannedPath& path, double dt_s)
    : patient_(&patient),
      path_(path),
      dt_s_(dt_s),
      surroundings_(patient, path),
      metrics_(path, surroundings_.ductAxis(), dt_s),
      entry_side_(sideOfReference(patient.package().motion, path.entry_reference_m)),
      target_side_(sideOfReference(patient.package().motion, path.target_reference_m)),
      check_interval_ticks_(std::uint64_t(std::max(1.0, std::floor(kCheckInterval_s / dt_s + 0.5)))) {
    const Vec3 way = path.target_reference_m - path.entry_reference_m;
    if (glm::length(way) > 0.0) axis_reference_ = glm::normalize(way);
}

CurrentPath Procedure::currentPath(const patient::Surrogate& breath) noexcept {
    const MotionModel& motion = patient_->package().motion;
    CurrentPath now;
    now.entry_m = follow(entry_motion_, motion, breath, entry_side_, path_.entry_reference_m);
    now.target_m = follow(target_motion_, motion, breath, target_side_, path_.target_reference_m);
    const double length_m = glm::length(now.target_m - now.entry_m);
    if (length_m > 0.0) now.axis = (now.target_m - now.entry_m) / length_m;
    return now;
}

RiskStructure Procedure::findCurrentRisk(const TickOutput& now) const noexcept {
    if (now.phase == haptics::Phase::outside) return RiskStructure::nothing;
    if (bone_held_) return RiskStructure::bone;
    if (const Label* label = patient_->label(now.label))
        return label->role == Role::risk ? classifyRisk(label->tissue) : RiskStructure::nothing;
    if (now.tissue == Tissue::air)
        return now.depth_m > kGasDepth_m ? RiskStructure::lung : RiskStructure::nothing;
    return patient_->row(now.tissue).role == Role::risk ? classifyRisk(now.tissue) : RiskStructure::nothing;
}

bool Procedure::inTarget(const TickOutput& now) const noexcept {
    const Label* label = patient_->label(now.label);
    return now.tissue == Tissue::duct && label && label->role == Role::target;
}

TickFacts Procedure::computeFacts(const TickOutput& now) noexcept {
    TickFacts facts;
    facts.path = currentPath(now.breath);
    facts.inside = now.phase != haptics::Phase::outside;
    facts.in_target = facts.inside && inTarget(now);
    facts.clearance_m = std::numeric_limits<double>::infinity();
    if (facts.inside) {
        facts.clearance_m = surroundings_.distanceToRisk_m(now.tip_reference_m);
        facts.to_duct_m = surroundings_.distanceToDuct_m(now.tip_reference_m);
    }
    bone_held_ = bone_held_ && now.phase == haptics::Phase::tenting;
    facts.current_risk = findCurrentRisk(now);
    const Pose& tool = haptics::isNeedleTool(now.tool) ? now.patient_from_needle : now.patient_from_tool;
    const Vec3 from_entry = tool.position_m - facts.path.entry_m, into = -tool.direction({0, 0, 1});
    facts.off_path_m = glm::length(glm::cross(from_entry, facts.path.axis));
    facts.off_angle_rad =
        std::atan2(glm::length(glm::cross(into, facts.path.axis)), glm::dot(into, facts.path.axis));
    facts.to_target_m = glm::length(tool.position_m - facts.path.target_m);
    return facts;
}

void Procedure::update(const TickOutput& now, const AttemptFold& fold) {
    if (!std::exchange(begun_, true)) {
        first_tick_ = now.tick;
        previous_ = now;
        addEvent(now.tick, "tool", std::string(haptics::kToolNames[std::size_t(now.tool)]));
    }
    const TickFacts facts = computeFacts(now);
    updateSteps(now, facts, fold);
    metrics_.update(now, facts, fold);
    progress_.elapsed_s = double(now.tick - first_tick_) * dt_s_;
    progress_.off_path_m = facts.off_path_m;
    progress_.off_angle_rad = facts.off_angle_rad;
    progress_.to_target_m = facts.to_target_m;
    progress_.clearance_m = facts.clearance_m;
    progress_.current_risk = facts.current_risk;
    if (facts.current_risk != RiskStructure::nothing) progress_.last_risk = facts.current_risk;
    reportChanges(now);
    updateScore();
    previous_ = now;
}

void Procedure::update(const NeedleEvent& event, const TickOutput& now, bool target_cut) {
    if (event.kind == NeedleEventKind::border && event.border.to == Tissue::bone) bone_held_ = true;
    if (event.kind == NeedleEventKind::puncture) {
        metrics_.recordPunctureForce(event.force_before_n);
        addEvent(now.tick, "cut",
                 std::string(patient::tissueName(event.border.to)) +
                     inMm(" at {:.1f} mm", event.border.depth_m + event.tenting_m));
    }
    if (target_cut && !progress_.success) {
        progress_.success = true;
        metrics_.recordTargetPuncture(now);
        finish(Step::advance, now.tick);
    }
    updateScore();
}

void Procedure::updateScore() noexcept {
    metrics_.setSteps(progress_.steps_done, progress_.out_of_order);
    progress_.risk_hits = metrics_.riskHits();
    progress_.near_misses = metrics_.nearMisses();
    progress_.total = computeScore(metrics_.values()).total;
}

void Procedure::updateSteps(const TickOutput& now, const TickFacts& facts, const AttemptFold& fold) {
    const auto undone = [&](Step step) { return (progress_.steps_done & 1u << unsigned(step)) == 0; };
    const bool look = (now.tick - first_tick_) % check_interval_ticks_ == 0;
    const double looked_s = double(check_interval_ticks_) * dt_s_;
    if (look && undone(Step::findGap) && now.tool == Tool::finger) {
        const bool pressed = glm::length(now.tool_force.force_n) > kPressed_n;
        const bool found =
            pressed && isInPathGap(patient::referenceFromDeformed(patient_->package().motion, now.breath,
                                                                  now.patient_from_tool.position_m));
        pressed_s_ = found ? pressed_s_ + looked_s : 0.0;
        if (pressed_s_ >= kMinPress_s) finish(Step::findGap, now.tick);
    }
    if (look && undone(Step::findDuct)) {
        shown_s_ =
            showsTarget(now, facts.path.target_m, fold.equipment().ultrasound) ? shown_s_ + looked_s : 0.0;
        if (shown_s_ >= kMinVisible_s) finish(Step::findDuct, now.tick);
    }
    if (undone(Step::incise) && now.incision_count > 0 && opensEntry(now.newest_incision))
        finish(Step::incise, now.tick);
    if (undone(Step::guide) && now.needle_in_guide) finish(Step::guide, now.tick);
    const std::uint64_t pulses = fold.dose().pulses;
    if (undone(Step::contrast) && pulses != pulses_ &&
        fold.contrast().volumes().ducts_m3 >= kShownContrast_m3)
        finish(Step::contrast, now.tick);
    pulses_ = pulses;
}

// True if there is no bone under a point of the skin, along the path's direction.
bool Procedure::isOverGap(const Vec3& reference_m) const noexcept {
    for (double at_m = -kBeforeSkin_m; at_m <= kRibDepth_m; at_m += kSample_m)
        if (patient_->at(reference_m + axis_reference_ * at_m, {true, false}).tissue == Tissue::bone)
            return false;
    return true;
}

// True if the point lies in the same intercostal space as the path's entry: no rib between them.
bool Procedure::isInPathGap(const Vec3& reference_m) const noexcept {
    const Vec3 way = path_.entry_reference_m - reference_m;
    const double length_m = glm::length(way);
    if (!(length_m <= kSpaceReach_m)) return false;
    const int pieces = std::max(1, int(std::ceil(length_m / kAside_m)));
    for (int i = 0; i < pieces; ++i)
        if (!isOverGap(reference_m + way * (double(i) / pieces))) return false;
    return true;
}

// True if the target lies in the picture of the probe on the skin, with neither rib nor gas in front of it.
bool Procedure::showsTarget(const TickOutput& now, const Vec3& target_m,
                            const UltrasoundState& machine) const noexcept {
    if (!now.probe_parked && !(now.tool == Tool::probe && now.probe_touching_share > 0.0)) return false;
    const Pose patient_from_probe =
        now.probe_parked ? now.patient_from_probe : now.patient_from_tool * haptics::kStylusFromProbe;
    const Vec3 p = patient_from_probe.inverse() * target_m;
    if (!(std::fabs(p.y) <= kDuctInPlane_m) || !(p.z > 0.0)) return false;
    Vec3 from(p.x, 0.0, 0.0);  // point of the probe's face at which the beam starts
    if (machine.transducer == 0) {
        const Vec3 centre(0.0, 0.0, -kConvexRadius_m);
        const Vec3 beam = Vec3(p.x, 0.0, p.z) - centre;
        if (std::fabs(std::atan2(beam.x, beam.z)) > kConvexHalfAngle_rad) return false;
        from = centre + beam * (kConvexRadius_m / glm::length(beam));
    } else if (std::fabs(p.x) > kLinearHalfWidth_m) {
        return false;
    }
    const double length_m = glm::length(p - from);
    if (!(length_m <= machine.depth_m)) return false;
    const MotionModel& motion = patient_->package().motion;
    bool in_body = false;
    for (double at_m = 0.0; at_m < length_m; at_m += kSample_m) {
        const Vec3 at = patient_from_probe * glm::mix(from, p, at_m / length_m);
        const patient::TissueSample sample =
            patient_->at(patient::referenceFromDeformed(motion, now.breath, at), {true, false});
        if (sample.tissue == Tissue::bone || (in_body && sample.tissue == Tissue::air)) return false;
        in_body = in_body || (sample.tissue != Tissue::air && at_m > kBeforeSkin_m);
    }
    return true;
}

bool Procedure::opensEntry(const haptics::Incision& cut) const noexcept {
    return distanceToSegment_m(path_.entry_reference_m, cut.begin_reference_m, cut.end_reference_m) <=
           kAtEntry_m;
}

void Procedure::finish(Step step, std::uint64_t tick) {
    const std::uint32_t bit = 1u << unsigned(step), later = progress_.steps_done & ~(bit - 1);
    progress_.steps_done |= bit;
    early_steps_ |= later;
    progress_.out_of_order = std::uint32_t(std::popcount(early_steps_));
    int next = 0;
    while (next < kStepCount && (progress_.steps_done & 1u << next) != 0)
        ++next;
    progress_.step = Step(next);
    addEvent(tick, "step", std::string(stepName(step)) + (later != 0 ? ", after a later one" : ""));
}

void Procedure::reportChanges(const TickOutput& now) {
    if (now.tool != previous_.tool)
        addEvent(now.tick, "tool", std::string(haptics::kToolNames[std::size_t(now.tool)]));
    if (now.probe_parked != previous_.probe_parked)
        addEvent(now.tick, "tool", now.probe_parked ? "probe parked" : "probe taken off");
    if (now.breath_held != previous_.breath_held)
        addEvent(now.tick, "breath", now.breath_held ? "held" : "breathes again");
    if (metrics_.contactNow())
        addEvent(now.tick, "contact",
                 std::string(haptics::kToolNames[std::size_t(now.tool)]) + " on the skin");
    if (metrics_.riskHitNow())
        addEvent(now.tick, "risk",
                 std::string(riskStructureName(progress_.current_risk)) + inMm(" at {:.1f} mm", now.depth_m));
    if (const auto nearest_m = metrics_.nearMissNow_m())
        addEvent(now.tick, "near_miss", inMm("passed a risk structure at {:.1f} mm", *nearest_m));
    if (const std::uint32_t fresh = now.faults & ~previous_.faults)
        for (const haptics::FaultText& fault : haptics::faultTexts())
            if ((fresh & fault.bit) != 0) addEvent(now.tick, "fault", fault.name);
}

void Procedure::addEvent(std::uint64_t tick, const char* kind, std::string text) {
    assert(isEventKind(kind));
    events_.push_back({tick, kind, std::move(text)});
}

}  // namespace stylet::training
