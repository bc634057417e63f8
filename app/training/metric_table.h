// The list of metrics, model.md section 9; the guide's metrics.md has the same table. To add one: add an id
// and a row here, its row in metrics.md, and a test. A metric that needs more state than its own previous
// value is computed in metrics.cpp.
//
// Based on Johnson et al., Br. J. Radiol. 2012 (doi 10.1259/bjr/47436030). They found which metrics of a
// simulated liver biopsy distinguish experts from trainees.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "app/training/attempt_fold.h"
#include "app/training/progress.h"

namespace stylet::training {

// The reference path at the current breath. In the breathing state of its plan it equals the planned line.
struct CurrentPath {
    Vec3 entry_m{0.0}, target_m{0.0};
    Vec3 axis{0.0, 0.0, 1.0};  // unit, into the body
};

// Quantities derived from one tick.
struct TickFacts {
    CurrentPath path;
    bool inside = false;  // needle in the body
    bool in_target = false;
    double clearance_m = 0.0, to_duct_m = 0.0;  // while `inside` (surroundings.h)
    RiskStructure current_risk = RiskStructure::nothing;
    double off_path_m = 0.0, off_angle_rad = 0.0, to_target_m = 0.0, past_target_m = 0.0;
    bool infiltrates = false;  // the needle brings local anaesthetic and stays outside the liver
    double pain = 0.0;         // worst so far
    double torn_m = 0.0;       // length of the track that the drain tore so far (pain.h)
    double in_beam = 0.0;      // share of the needle in the ultrasound beam (evidence.h)
    bool target_cut = false;   // the target duct was punctured in an earlier tick
};

// Smaller motion of the tip is tremor (0.1 mm amplitude).
inline constexpr double kMinMotion_m = 0.001;

struct MetricTick {
    const haptics::TickOutput& now;
    const TickFacts& facts;
    const AttemptFold& attempt;
    double dt_s;
};

// In the table's order. Append, never insert: records store metrics by id, but tests and reports rely on
// the order.
enum class MetricId : std::uint8_t {
    procedure,
    outOfOrder,
    targeting,
    noGoTouches,
    noGoTime,
    needleInBeam,
    probeTime,
    sessionTime,
    skinContacts,
    needlePath,
    entryOff,
    angleOff,
    vesselHits,
    boneHits,
    lungHits,
    organHits,
    nearMisses,
    clearance,
    ductAngle,
    breathAtCapsule,
    movedBreathing,
    lateralCut,
    fluoroscopy,
    dose,
    contrast,
    contrastAstray,
    peakForce,
    pain,
    anaesthetic,
    tornTrack,
    caseReview,
    count,
};
inline constexpr std::size_t kMetricCount = std::size_t(MetricId::count);

struct Metric {
    std::string_view id;    // id in records and files
    std::string_view name;  // readable name
    std::string_view unit;  // of value, best and worst; "" for counts
    std::string_view what;
    std::string_view source;
    double weight = 0.0;  // the sum over all metrics of a puncture is 100
    double best = 0.0, worst = 0.0;
    // The metric earns points only if this step was done, so that nobody gains by leaving a step out.
    // Step::done: always.
    Step needs = Step::done;
    // Returns the value after a tick from the value before it. Before the first tick it is 0. Null:
    // metrics.cpp computes the metric.
    double (*fold)(double so_far, const MetricTick&) noexcept = nullptr;
    // Only attempts of this course or a longer one have the metric.
    Course from = Course::puncture;
};
constexpr bool isMetricOf(Course course, const Metric& metric) noexcept {
    return metric.from <= course;
}

inline constexpr std::string_view kJohnson = "Johnson 2012", kModel = "model.md 9",
                                  kMastmeyer = "Mastmeyer 2017", kOurs = "ours";

// The weights were fixed before any attempt was scored. Johnson's metrics have 54 points in total: the
// smaller the p-value with which a metric distinguished experts from trainees, the more points it has.
// Targeting has the most points because it is the purpose of the needle. The remaining points go to the
// procedure, to harm and to effort, with effort last.
inline constexpr std::array<Metric, kMetricCount> kMetricTable{{
    {"procedure", "Procedure done", "%",
     "of all parts: three for the puncture (one if it was blind or in a moving liver), three for the drain, "
     "one for each other step",
     kModel, 8, 100, 0, Step::done},
    {"out_of_order", "Steps out of order", "", "steps done before one that comes earlier", kModel, 4, 0, 3,
     Step::advance},
    {"targeting", "Targeting", "mm", "nearest that the tip came to the target in its duct", kJohnson, 10, 3,
     20, Step::done},
    {"no_go_touches", "No-go areas touched", "", "times the needle came into a risk structure", kJohnson, 8,
     0, 3, Step::advance},
    {"no_go_time", "Time in no-go areas", "s", "with the needle in one", kJohnson, 9, 0, 5, Step::advance,
     [](double so_far, const MetricTick& tick) noexcept {
         return so_far + (tick.facts.current_risk != RiskStructure::nothing ? tick.dt_s : 0.0);
     }},
    {"needle_in_beam", "Needle in the beam", "%", "of its length in the body, mean until the duct is cut",
     kJohnson, 4, 80, 0, Step::advance},
    {"probe_time", "Probe time", "s", "with the probe in hand on the skin", kJohnson, 5, 30, 180,
     Step::findDuct,
     [](double so_far, const MetricTick& tick) noexcept {
         const bool scans = tick.now.tool == haptics::Tool::probe && tick.now.probe_touching_share > 0.0;
         return so_far + (scans ? tick.dt_s : 0.0);
     }},
    {"session_time", "Session time", "s", "from the first tick", kJohnson, 5, 120, 600, Step::advance},
    {"skin_contacts", "Skin contacts", "", "times a tool came onto the skin", kJohnson, 9, 5, 20,
     Step::advance},
    {"needle_path", "Needle path", "path lengths",
     "way of the tip in the body over the reference path's length", kJohnson, 4, 2.5, 8, Step::advance},
    {"entry_off", "Entry off", "mm", "from the reference path's entry", kModel, 3, 3, 15, Step::advance},
    {"angle_off", "Angle off", "deg", "to the reference path, mean until the duct is cut", kModel, 3, 3, 20,
     Step::advance},
    {"vessel_hits", "Vessels hit", "", "blood vessels entered", kModel, 3, 0, 2, Step::advance},
    {"bone_hits", "Bones hit", "", "times the needle met bone or entered cartilage", kModel, 2, 0, 3,
     Step::advance},
    {"lung_hits", "Lung or gas hit", "", "times the needle came into air in the body", kModel, 3, 0, 2,
     Step::advance},
    {"organ_hits", "Other organs hit", "", "other risk structures entered", kModel, 2, 0, 2, Step::advance},
    {"near_misses", "Near misses", "",
     "closer than 2 mm, more than 10 mm before the duct; each graded 0 to 1, struck 1", kModel, 2, 0, 3,
     Step::advance},
    {"clearance", "Least clearance", "mm", "to a risk structure, more than 10 mm before the duct", kMastmeyer,
     3, 3, 0, Step::advance},
    {"duct_angle", "Angle to the duct", "deg", "between needle and duct as it is cut: the wire must turn",
     kMastmeyer, 1, 60, 90, Step::done},
    {"breath_at_capsule", "Breath at the capsule", "", "off the planned phase as the liver is entered",
     kModel, 2, 0.1, 0.6, Step::advance},
    {"moved_breathing", "Moved while breathing", "mm", "way of the tip in the body with the breath not held",
     kModel, 3, 5, 80, Step::advance},
    {"lateral_cut", "Cut sideways", "mm", "by the needle, across its shaft", kModel, 1, 0.5, 10,
     Step::advance,
     [](double so_far, const MetricTick& tick) noexcept {
         return std::max(so_far, 1e3 * tick.now.lateral_cut_m);
     }},
    {"fluoroscopy", "Fluoroscopy", "s", "pedal down", kModel, 1, 30, 300, Step::contrast,
     [](double, const MetricTick& tick) noexcept { return tick.attempt.dose().fluoroscopy_s; }},
    {"dose", "Dose-area product", "Gy cm2", "median of the procedure at worst", "Schmitz 2019", 1, 2, 21.6,
     Step::contrast,
     [](double, const MetricTick& tick) noexcept { return 1e4 * tick.attempt.dose().dose_area_gy_m2; }},
    {"contrast", "Contrast medium", "ml", "injected", kModel, 1, 20, 60, Step::contrast,
     [](double, const MetricTick& tick) noexcept { return 1e6 * tick.attempt.dose().contrast_m3; }},
    {"contrast_astray", "Contrast astray", "ml", "not in the ducts", kOurs, 1, 0.5, 10, Step::contrast,
     [](double so_far, const MetricTick& tick) noexcept {
         if (!tick.attempt.begun()) return so_far;
         return 1e6 *
                std::max(0.0, tick.attempt.dose().contrast_m3 - tick.attempt.contrast().volumes().ducts_m3);
     }},
    {"peak_force", "Peak force", "N", "of the model, along the needle", kModel, 2, 5, 15, Step::advance,
     [](double so_far, const MetricTick& tick) noexcept {
         return std::max(so_far, std::fabs(tick.now.force_n));
     }},
    {"pain", "Worst pain", "of 10", "of skin prick, incision, capsule, dilatation and a torn track", "pain.h",
     5, 3, 8, Step::dilate, [](double, const MetricTick& tick) noexcept { return tick.facts.pain; },
     Course::drainage},
    {"anaesthetic", "Local anaesthetic", "ml", "injected, of lidocaine 1 %", "FDA label", 1, 20, 30,
     Step::anaesthetise,
     [](double, const MetricTick& tick) noexcept { return 1e6 * tick.attempt.dose().anaesthetic_m3; },
     Course::drainage},
    {"torn_track", "Track torn", "mm", "by the drain, where the dilator had not been", "pain.h", 5, 2, 20,
     Step::drain, [](double, const MetricTick& tick) noexcept { return 1e3 * tick.facts.torn_m; },
     Course::drainage},
    {"case_review", "Case review", "", "questions about the case with a wrong answer or with none",
     "SIR 2019", 5, 0, 2, Step::done, nullptr, Course::drainage},
}};

// Version of the score, stored with every result. Increment it with each change of this table or of the
// formula (score.cpp) that changes a score. "stylet replay --fast" scores an older attempt again.
inline constexpr int kScoreVersion = 4;
// From this version on an exam needs every part of it (kExamParts in score.h); before, only the course's
// goal.
inline constexpr int kExamPartsVersion = 4;

constexpr double weightSum(Course course) {
    double sum = 0.0;
    for (const Metric& m : kMetricTable)
        if (isMetricOf(course, m)) sum += m.weight;
    return sum;
}
static_assert(weightSum(Course::puncture) == 100.0);

}  // namespace stylet::training
