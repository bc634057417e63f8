#include "app/training/procedure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <tuple>
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

constexpr std::array<std::string_view, std::size_t(kStepCount) + 1> kStepNames{
    "review the case",
    "find the space between the ribs",
    "find the duct",
    "numb the track",
    "open the skin",
    "snap the needle into the guide",
    "advance to the duct",
    "draw bile",
    "show the ducts with contrast",
    "pass the wire down the duct",
    "dilate the track",
    "place the drain",
    "show the drain with contrast",
    "done"};
constexpr std::array<std::string_view, kRefusalCount> kRefusalTexts{
    "",
    "the space between the ribs was not pressed with the finger",
    "the rib above the space was not felt",
    "the rib below the space was not felt",
    "the probe does not touch the skin",
    "the duct lies beside the picture's plane: tilt or shift the probe",
    "the duct lies outside the picture: shift the probe or set a greater depth",
    "a rib or gas hides the duct",
    "the duct was not in the picture for a second",
    "the guide's line passes beside the duct",
    "the incision is not at the entry",
    "the incision is shorter than 3 mm",
    "the incision is longer than 15 mm",
    "the needle is not on the guide's rail",
    "the ultrasound picture did not show the needle on most of its way to the duct",
    "the duct was punctured while the patient breathed",
    "the duct was not in the ultrasound picture as it was punctured",
    "the needle has passed beside the duct",
    "no bile was drawn: the needle's tip is not in a duct",
    "blood was drawn: the needle's tip is in a vessel",
    "no bile was drawn: the wire fills the needle",
    "the contrast medium is not in the ducts",
    "the wire does not lie 20 mm down the duct",
    "the wire has pierced the duct's wall: draw it back",
    "the dilator did not reach the duct",
    "the drain's end does not lie in a duct: pass the wire through it again",
    "side holes lie short of the duct, bile leaks: pass the wire again, push the drain on",
    "side holes lie past the duct, bile leaks: pass the wire again, pull the drain back",
    "the drain tears a track that was not dilated: draw it back and use the dilator",
    "neither bile nor contrast medium has proved a duct",
    "the skin at the entry is not numb: inject 0.5 ml just under it",
    "the liver's capsule is not numb: inject 2 ml in front of it",
    "local anaesthetic went into a vessel: draw with the syringe before you inject",
    "local anaesthetic was lost: the needle's tip is not in tissue",
    "local anaesthetic was injected beside the later track",
    "local anaesthetic was injected beyond the liver's capsule: draw back",
    "more than 20 ml of local anaesthetic",
    "the drain is straight again: draw the wire out until it curls"};
constexpr std::array<std::string_view, kCriticalErrorCount> kCriticalErrorNames{
    "the lung was punctured",
    "the stomach or bowel was punctured",
    "the gallbladder was punctured",
    "a major vessel was punctured",
    "the liver's capsule was punctured more than three times",
    "too much local anaesthetic was injected, or too much of it into a vessel",
    "the wire was pushed in without proof that the needle was in a duct",
    "the case was not reviewed before the body was opened, or mostly wrongly",
    "the case was judged at the patient's risk"};
constexpr std::array<std::string_view, kRiskStructureCount> kRiskStructureNames{
    "nothing", "bone or cartilage", "vessel", "lung or gas", "another organ"};

std::string inMm(fmt::format_string<double> format, double metres) {
    return fmt::format(format, metres * 1e3);
}

patient::Side sideOfReference(const MotionModel& motion, const Vec3& reference_m) {
    return patient::cavityLevel_m(motion, reference_m) < 0.0 ? patient::Side::inside : patient::Side::outside;
}

RiskStructure classifyRisk(Tissue tissue) {
    if (isSkeleton(tissue)) return RiskStructure::bone;
    if (tissue == Tissue::vessel) return RiskStructure::vessel;
    return tissue == Tissue::air ? RiskStructure::lung : RiskStructure::otherOrgan;
}

}  // namespace

std::string_view stepName(Step step) noexcept {
    return enumName(kStepNames, step);
}

std::string_view refusalText(Refusal refusal) noexcept {
    return enumName(kRefusalTexts, refusal);
}

std::string_view criticalErrorName(CriticalError error) noexcept {
    return enumName(kCriticalErrorNames, error);
}

std::string_view riskStructureName(RiskStructure structure) noexcept {
    return enumName(kRiskStructureNames, structure);
}

bool isDecisive(std::string_view kind, std::string_view text, bool exam) noexcept {
    if (kind == "answer") return exam;
    if (kind == "step") return exam || !text.starts_with(stepName(Step::reviewCase));
    if (kind == "contact") return !text.starts_with("finger") && !text.starts_with("probe");
    constexpr std::array<std::string_view, 6> kDecisive{"refused",  "risk", "near_miss",
                                                        "critical", "cut",  "pain"};
    return std::find(kDecisive.begin(), kDecisive.end(), kind) != kDecisive.end();
}

Procedure::Procedure(const patient::Patient& patient, const patient::PlannedPath& path, double dt_s)
    : patient_(&patient),
      path_(path),
      dt_s_(dt_s),
      surroundings_(patient, path),
      metrics_(path, surroundings_.ductAxis(), dt_s),
      evidence_(patient, path, dt_s),
      safety_(patient),
      pain_(patient, dt_s),
      entry_side_(sideOfReference(patient.package().motion, path.entry_reference_m)),
      target_side_(sideOfReference(patient.package().motion, path.target_reference_m)) {}

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

// The needle brings local anaesthetic: an insertion of a free needle before the track is numb and the skin
// cut, as long as it stays outside the liver.
bool Procedure::infiltrates(const TickOutput& now) const noexcept {
    if (progress_.course != Course::drainage || now.phase == haptics::Phase::outside || now.access.open ||
        now.tissue == Tissue::liver)
        return false;
    if (previous_.phase != haptics::Phase::outside) return infiltrates_;
    const bool open =
        contains(progress_.steps_done, Step::anaesthetise) || contains(progress_.steps_done, Step::incise);
    return !open && !now.needle_in_guide;
}

TickFacts Procedure::computeFacts(const TickOutput& now) noexcept {
    TickFacts facts;
    facts.path = currentPath(now.breath);
    facts.inside = now.phase != haptics::Phase::outside;
    facts.in_target = facts.inside && inTarget(now);
    facts.target_cut = progress_.success;
    facts.infiltrates = infiltrates_ = infiltrates(now);
    facts.pain = pain_.worst();
    facts.torn_m = pain_.torn_m();
    if (facts.inside) facts.in_beam = shareInBeam(now);
    facts.clearance_m = std::numeric_limits<double>::infinity();
    if (facts.inside) {
        facts.clearance_m = surroundings_.distanceToRisk_m(now.tip_reference_m);
        facts.to_duct_m = surroundings_.distanceToDuct_m(now.tip_reference_m);
    }
    bone_held_ = bone_held_ && now.phase == haptics::Phase::tenting;
    facts.current_risk = findCurrentRisk(now);
    const bool needle = haptics::isNeedleTool(now.tool) || now.access.needle_in;
    // A probe is well placed if the line of its guide is the path.
    const Pose tool = needle ? now.patient_from_needle
                      : now.tool == Tool::probe
                          ? now.patient_from_tool * haptics::kStylusFromProbe * guide_.probe_from_guide
                          : now.patient_from_tool;
    const Vec3 from_entry = tool.position_m - facts.path.entry_m, into = -tool.direction({0, 0, 1});
    facts.off_path_m = glm::length(glm::cross(from_entry, facts.path.axis));
    facts.off_angle_rad =
        std::atan2(glm::length(glm::cross(into, facts.path.axis)), glm::dot(into, facts.path.axis));
    const Vec3 from_target = tool.position_m - facts.path.target_m;
    facts.to_target_m = glm::length(from_target);
    facts.past_target_m = glm::dot(from_target, facts.path.axis);
    return facts;
}

void Procedure::update(const TickOutput& now, const AttemptFold& fold) {
    if (!std::exchange(begun_, true)) {
        first_tick_ = now.tick;
        previous_ = now;
        addEvent(now.tick, "tool", std::string(haptics::kToolNames[std::size_t(now.tool)]));
    }
    updatePain(now, fold);
    updateReview(now, fold);
    const TickFacts facts = computeFacts(now);
    updateSteps(now, facts, fold);
    updateSafety(now, facts, fold);
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
    }
    updateScore();
}

void Procedure::updateScore() noexcept {
    metrics_.setSteps(stepsOf(progress_), progress_.steps_done, progress_.out_of_order);
    metrics_.setWrongAnswers(review_.wrong());
    progress_.risk_hits = metrics_.riskHits();
    progress_.near_misses = metrics_.nearMisses();
    progress_.total = score().total;
}

void Procedure::updateSteps(const TickOutput& now, const TickFacts& facts, const AttemptFold& fold) {
    std::uint32_t found = evidence_.update(now, facts, fold);
    if (review_.isDone()) found |= 1u << unsigned(Step::reviewCase);
    // A drain that was straightened again must be placed, and pictured, anew.
    constexpr std::uint32_t kOfDrain = 1u << unsigned(Step::drain) | 1u << unsigned(Step::finalPicture);
    if (const std::uint32_t lost = progress_.steps_done & kOfDrain & ~found; lost != 0) {
        progress_.steps_done &= ~lost;
        refuse(Refusal::drainStraightened, now.tick);
    }
    for (int step = 0; step < kStepCount; ++step)
        if (contains(found & ~progress_.steps_done & stepsOf(progress_), Step(step)))
            finish(Step(step), now.tick);
    progress_.step = firstMissing(now);
    progress_.missing = progress_.step == Step::done ? Refusal::none : evidence_.missing(progress_.step);
    progress_.track_place = evidence_.trackPlace();
    std::tie(progress_.depot_m3, progress_.depot_wanted_m3) = evidence_.depotAtTip_m3();
    if (const Refusal refusal = evidence_.popRefusal(); refusal != Refusal::none) refuse(refusal, now.tick);
}

void Procedure::refuse(Refusal refusal, std::uint64_t tick) {
    progress_.refusal = refusal;
    progress_.refused_s = double(tick - first_tick_) * dt_s_;
    addEvent(tick, "refused", std::string(refusalText(refusal)));
}

void Procedure::updatePain(const TickOutput& now, const AttemptFold& fold) {
    if (progress_.course != Course::drainage) return;
    pain_.update(now, fold.anaesthetic());
    progress_.pain = pain_.now();
    progress_.worst_pain = pain_.worst();
    if (const std::optional<PainEvent> event = pain_.eventNow())
        addEvent(now.tick, "pain", fmt::format("{:.0f} of 10: {}", event->pain, event->cause));
}

void Procedure::updateReview(const TickOutput& now, const AttemptFold& fold) {
    if (progress_.course != Course::drainage) return;
    review_.update(now, fold.answers());
    while (const std::optional<Question> question = review_.popAnswered()) {
        const bool yes = review_.answer(*question);
        progress_.answered = std::uint8_t(int(*question) + 1);
        progress_.yes |= yes ? 1u << unsigned(*question) : 0u;
        progress_.answered_s = double(now.tick - first_tick_) * dt_s_;
        addEvent(now.tick, "answer", describeAnswer(*review_.patientCase(), *question, yes));
    }
}

void Procedure::updateSafety(const TickOutput& now, const TickFacts& facts, const AttemptFold& fold) {
    safety_.update(now, facts);
    safety_.judgeDose(fold.anaesthetic().volumes());
    if (progress_.course == Course::drainage) safety_.judgeWire(now.access, evidence_.provesDuct());
    progress_.capsule_punctures = safety_.capsulePunctures();
    const std::uint32_t errors = safety_.errors() | review_.errors();
    const std::uint32_t fresh = errors & ~std::exchange(progress_.critical_errors, errors);
    for (int error = 0; error < kCriticalErrorCount; ++error)
        if ((fresh & 1u << error) != 0)
            addEvent(now.tick, "critical", std::string(criticalErrorName(CriticalError(error))));
}

void Procedure::finish(Step step, std::uint64_t tick) {
    const std::uint32_t bit = 1u << unsigned(step), later = progress_.steps_done & ~(bit - 1);
    progress_.steps_done |= bit;
    progress_.refusal = Refusal::none;
    early_steps_ |= later;
    progress_.out_of_order = std::uint32_t(std::popcount(early_steps_));
    addEvent(tick, "step", std::string(stepName(step)) + (later != 0 ? ", after a later one" : ""));
}

// Passes over the steps that cannot be done any more, so that nobody is asked for them.
Step Procedure::firstMissing(const TickOutput& now) const noexcept {
    constexpr std::uint32_t kOfNeedle = 1u << unsigned(Step::anaesthetise) | 1u << unsigned(Step::guide) |
                                        1u << unsigned(Step::advance) | 1u << unsigned(Step::aspirate) |
                                        1u << unsigned(Step::contrast);
    std::uint32_t passed = progress_.steps_done | (kAllSteps & ~stepsOf(progress_));
    if (review_.isOver()) passed |= 1u << unsigned(Step::reviewCase);
    if (evidence_.isIncisionSpoiled()) passed |= 1u << unsigned(Step::incise);
    // Anaesthesia is asked for before the cut only.
    if (contains(progress_.steps_done, Step::incise)) passed |= 1u << unsigned(Step::anaesthetise);
    if (now.access.wire_in) passed |= kOfNeedle;
    // A drain without its wire lies in the way of everything but its own mending.
    if (now.access.drain == haptics::DrainState::in_place ||
        now.access.drain == haptics::DrainState::misplaced)
        passed |= (1u << unsigned(Step::drain)) - 1u;
    return Step(std::countr_one(passed));
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
