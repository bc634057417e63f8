// Progress of an attempt, for panel, sound, console and report. Derived from the ticks (procedure.h), never
// hashed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

namespace stylet::training {

// Steps of the procedure, in order. evidence.h: what each needs.
enum class Step : std::uint8_t {
    reviewCase,
    findGap,
    findDuct,
    anaesthetise,
    incise,
    guide,
    advance,
    aspirate,
    contrast,
    wire,
    dilate,
    drain,
    finalPicture,
    done
};
inline constexpr int kStepCount = int(Step::done);
inline constexpr std::uint32_t kAllSteps = (1u << kStepCount) - 1u;  // bit mask of 1 << Step
std::string_view stepName(Step) noexcept;                            // "find the space between the ribs"
constexpr bool contains(std::uint32_t steps, Step step) noexcept {
    return (steps & 1u << unsigned(step)) != 0;
}

// The part of the procedure that an attempt consists of: up to the puncture and its picture, or all of it.
enum class Course : std::uint8_t { puncture, drainage };
inline constexpr std::array<std::string_view, 2> kCourseNames{"puncture", "drainage"};
inline constexpr Course kDefaultCourse = Course::puncture;  // of a scenario that names none
constexpr std::uint32_t stepsOf(Course course) noexcept {   // bit mask
    constexpr std::uint32_t kFurther = 1u << unsigned(Step::reviewCase) | 1u << unsigned(Step::anaesthetise) |
                                       1u << unsigned(Step::aspirate) | 1u << unsigned(Step::wire) |
                                       1u << unsigned(Step::dilate) | 1u << unsigned(Step::drain) |
                                       1u << unsigned(Step::finalPicture);
    return course == Course::drainage ? kAllSteps : kAllSteps & ~kFurther;
}
constexpr bool hasAnaesthesia(Course course) noexcept {
    return contains(stepsOf(course), Step::anaesthetise);
}
// The step that the course is for. Records name their course by it.
constexpr Step goalOf(Course course) noexcept {
    return course == Course::drainage ? Step::drain : Step::advance;
}

// Why a step that was tried does not count.
enum class Refusal : std::uint8_t {
    none,
    gapNotFelt,
    upperRibNotFelt,
    lowerRibNotFelt,
    noContact,
    ductBesidePlane,
    ductOutsidePicture,
    ductShadowed,
    ductTooShort,
    ductBesideRail,
    incisionAside,
    incisionTooShort,
    incisionTooLong,
    needleNotInGuide,
    needleNotSeen,
    breathNotHeld,
    ductNotSeen,
    ductMissed,
    noBile,
    bloodDrawn,
    wireInNeedle,
    contrastAstray,
    wireNotInDuct,
    wirePierced,
    notDilated,
    drainMisplaced,
    drainLeaks,
    drainTooDeep,
    trackTorn,
    wireUnproven,
    skinNotNumb,
    capsuleNotNumb,
    anaestheticInVessel,
    anaestheticLost,
    anaestheticAside,
    anaestheticBeyond,
    tooMuchAnaesthetic,
    drainStraightened  // it was in its place
};
inline constexpr int kRefusalCount = int(Refusal::drainStraightened) + 1;
std::string_view refusalText(Refusal) noexcept;  // "the needle is not on the guide's rail"

// Errors that fail an exam whatever the score (safety.h, case_review.h).
enum class CriticalError : std::uint8_t {
    lung,
    bowel,
    gallbladder,
    majorVessel,
    capsule,
    overdose,
    blindWire,
    unreviewed,
    unfit
};
inline constexpr int kCriticalErrorCount = int(CriticalError::unfit) + 1;
std::string_view criticalErrorName(CriticalError) noexcept;  // "the gallbladder was punctured"

// Where the needle's tip is on the track through the body wall (infiltration.h), from outside to inside.
enum class TrackPlace : std::uint8_t { outside, skin, wall, capsule, beyond, aside };

// The risk structure that the needle is in.
enum class RiskStructure : std::uint8_t { nothing, bone, vessel, lung, otherOrgan };
inline constexpr int kRiskStructureCount = 5;
std::string_view riskStructureName(RiskStructure) noexcept;

// Trivially copyable, for snapshots. State at one tick, patient frame.
struct Progress {
    Course course = kDefaultCourse;
    Step step = Step::findGap;       // first step of the course that is not done and can be done
    std::uint32_t steps_done = 0;    // bit mask, 1 << Step
    std::uint32_t out_of_order = 0;  // steps done before an earlier one
    double elapsed_s = 0.0;          // since the first tick
    // For the needle, or for the current tool if it is not a needle: distance of the tip from the reference
    // path at the current breath, angle between shaft and path, distance from tip to target. For the probe:
    // of the line of its guide, from the guide's opening.
    double off_path_m = 0.0, off_angle_rad = 0.0, to_target_m = 0.0;
    // Distance from the needle's tip to the nearest risk structure. Infinite outside the body and beyond
    // the computed surroundings of the path (surroundings.h).
    double clearance_m = std::numeric_limits<double>::infinity();
    RiskStructure current_risk = RiskStructure::nothing;  // at this tick
    RiskStructure last_risk = RiskStructure::nothing;
    std::uint32_t risk_hits = 0, near_misses = 0;  // so far
    std::uint32_t critical_errors = 0;             // bit mask, 1 << CriticalError
    int capsule_punctures = 0;                     // of the liver, at different places
    bool success = false;                          // target duct punctured
    TrackPlace track_place = TrackPlace::outside;  // of the needle's tip
    // With the tip at an end of the track (TrackPlace skin or capsule): the local anaesthetic there so far,
    // and what is needed there. Elsewhere 0.
    double depot_m3 = 0.0, depot_wanted_m3 = 0.0;
    double pain = 0.0, worst_pain = 0.0;  // 0 to 10 (pain.h): now, and so far
    double total = 0.0;                   // score up to now, 0 to 100 (score.h)
    Refusal missing = Refusal::none;      // what the current step lacks now
    Refusal refusal = Refusal::none;      // the newest
    double refused_s = 0.0;               // `elapsed_s` of the newest refusal
    bool has_case = false;                // there is a case to review (case_review.h)
    std::uint8_t answered = 0;            // questions about the case
    std::uint32_t yes = 0;                // their answers, bit mask, 1 << Question
    double answered_s = 0.0;              // `elapsed_s` of the newest answer
};
static_assert(std::is_trivially_copyable_v<Progress>);
// Steps of this attempt: a drainage without a case, recorded before there were cases, has none to review.
constexpr std::uint32_t stepsOf(const Progress& progress) noexcept {
    const std::uint32_t steps = stepsOf(progress.course);
    return progress.has_case ? steps : steps & ~(1u << unsigned(Step::reviewCase));
}

// All kinds of events. The guide's records.md describes the text of each (a test compares them). The last
// seven do not come from the procedure: instructor actions, a suggested rest, the start of a retry.
inline constexpr std::array<std::string_view, 19> kEventKinds{
    "tool",   "step",  "refused",  "contact", "risk",     "near_miss", "critical",   "cut",  "breath", "pain",
    "answer", "fault", "injected", "pause",   "bookmark", "comment",   "difficulty", "rest", "retry"};
constexpr bool isEventKind(std::string_view kind) {
    return std::find(kEventKinds.begin(), kEventKinds.end(), kind) != kEventKinds.end();
}

// An event for log, record and report.
struct SessionEvent {
    std::uint64_t tick = 0;
    std::string kind;  // one of kEventKinds
    std::string text;
};
// True for an event that the score or an exam's verdict counts: a step, a refused step, harm, a cut, or a
// tool on the skin other than finger and probe. From the first one on, an attempt counts even if its user
// ends it. Answers about the case, and its review, are such events in an exam only.
bool isDecisive(std::string_view kind, std::string_view text, bool exam) noexcept;

}  // namespace stylet::training
