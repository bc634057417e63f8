// Based on Johnson et al., Br. J. Radiol. 2012 (doi 10.1259/bjr/47436030), who found which metrics of a
// simulated liver biopsy distinguish experts from trainees.
#include "app/training/score.h"

#include <algorithm>
#include <cmath>

namespace stylet::training {

namespace {

constexpr std::string_view kJohnson = "Johnson 2012", kModel = "model.md 9", kMastmeyer = "Mastmeyer 2017",
                           kOurs = "ours";

// The weights were fixed before any attempt was scored. Johnson's metrics have 54 points in total: the
// smaller the p-value with which a metric distinguished experts from trainees, the more points it has.
// Targeting has the most points because it is the needle's purpose. The rest goes to the procedure, to harm
// and, last, to effort.
constexpr std::array<Metric, kMetricCount> kTable{{
    {"procedure", "Procedure done", "%", "half for the target duct cut, a tenth for each other step", kModel,
     8, 100, 0},
    {"out_of_order", "Steps out of order", "", "steps done before one that comes earlier", kModel, 4, 0, 3},
    {"targeting", "Targeting", "mm", "nearest that the tip came to the target in its duct", kJohnson, 10, 3,
     20},
    {"no_go_touches", "No-go areas touched", "", "times the needle came into a risk structure", kJohnson, 8,
     0, 3},
    {"no_go_time", "Time in no-go areas", "s", "with the needle in one", kJohnson, 9, 0, 5},
    {"needle_in_beam", "Needle in the beam", "%", "of its length in the body, mean over the way", kJohnson, 4,
     80, 0},
    {"probe_time", "Probe time", "s", "with the probe in hand on the skin", kJohnson, 5, 30, 180},
    {"session_time", "Session time", "s", "from the first tick", kJohnson, 5, 120, 600},
    {"skin_contacts", "Skin contacts", "", "times a tool came onto the skin", kJohnson, 9, 5, 20},
    {"needle_path", "Needle path", "path lengths",
     "way of the tip in the body over the reference path's length", kJohnson, 4, 2.5, 8},
    {"entry_off", "Entry off", "mm", "from the reference path's entry", kModel, 3, 3, 15},
    {"angle_off", "Angle off", "deg", "to the reference path, mean over the way", kModel, 3, 3, 20},
    {"vessel_hits", "Vessels hit", "", "blood vessels entered", kModel, 3, 0, 2},
    {"bone_hits", "Bones hit", "", "times the needle met bone", kModel, 2, 0, 3},
    {"lung_hits", "Lung or gas hit", "", "times the needle came into air in the body", kModel, 3, 0, 2},
    {"organ_hits", "Other organs hit", "", "other risk structures entered", kModel, 2, 0, 2},
    {"near_misses", "Near misses", "",
     "closer than 2 mm, more than 10 mm before the duct; each graded 0 to 1, struck 1", kModel, 2, 0, 3},
    {"clearance", "Least clearance", "mm", "to a risk structure, more than 10 mm before the duct", kMastmeyer,
     3, 3, 0},
    {"duct_angle", "Angle to the duct", "deg", "between needle and duct as it is cut: the wire must turn",
     kMastmeyer, 1, 60, 90},
    {"breath_at_capsule", "Breath at the capsule", "", "off the planned phase as the liver is entered",
     kModel, 2, 0.1, 0.6},
    {"moved_breathing", "Moved while breathing", "mm", "way of the tip in the body with the breath not held",
     kModel, 3, 5, 80},
    {"lateral_cut", "Cut sideways", "mm", "by the needle, across its shaft", kModel, 1, 0.5, 10},
    {"fluoroscopy", "Fluoroscopy", "s", "pedal down", kModel, 1, 30, 300},
    {"dose", "Dose-area product", "Gy cm2", "median of the procedure at worst", "Schmitz 2019", 1, 2, 21.6},
    {"contrast", "Contrast medium", "ml", "injected", kModel, 1, 20, 60},
    {"contrast_astray", "Contrast astray", "ml", "not in the ducts", kOurs, 1, 0.5, 10},
    {"peak_force", "Peak force", "N", "of the model, along the needle", kModel, 2, 5, 15},
}};

constexpr double weightSum() {
    double sum = 0.0;
    for (const Metric& m : kTable)
        sum += m.weight;
    return sum;
}
static_assert(weightSum() == 100.0);

// 1 at the best value and beyond, 0 at the worst value and beyond, 0 for NaN.
double credit(const Metric& m, double value) noexcept {
    if (std::isnan(value)) return 0.0;
    const double low = std::min(m.best, m.worst), high = std::max(m.best, m.worst);
    return (std::clamp(value, low, high) - m.worst) / (m.best - m.worst);
}

}  // namespace

std::span<const Metric> metricTable() noexcept {
    return kTable;
}

Score scoreOf(const MetricValues& values) noexcept {
    Score score;
    score.values = values;
    const double done =
        credit(kTable[std::size_t(MetricId::procedure)], values[std::size_t(MetricId::procedure)]);
    for (std::size_t i = 0; i < kMetricCount; ++i) {
        const Metric& m = kTable[i];
        score.most_points[i] = m.weight;
        score.points[i] = m.weight * credit(m, values[i]) * done;
        score.total += score.points[i];
    }
    return score;
}

}  // namespace stylet::training
