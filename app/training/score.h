// The score: all metrics of model.md section 9 in one table (also in the guide's metrics.md), and their
// total. Pure functions.
//
// A metric earns its full weight at its best value, nothing at its worst, and a linear share between. All
// points are then scaled by the completed share of the procedure (metric "procedure"), so an idle trainee
// earns no points for harming nobody. Each part is visible, the parts add up to the total, and a metric
// that gets worse never raises the total.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace stylet::training {

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
};
inline constexpr std::size_t kMetricCount = std::size_t(MetricId::peakForce) + 1;

struct Metric {
    std::string_view id;    // id in records and files
    std::string_view name;  // readable name
    std::string_view unit;  // of value, best and worst; "" for counts
    std::string_view what;
    std::string_view source;
    double weight = 0.0;  // the sum over all metrics is 100
    double best = 0.0, worst = 0.0;
};
std::span<const Metric> metricTable() noexcept;

// In the table's units and order. NaN, or infinity on the bad side, means not achieved and scores as the
// worst value.
using MetricValues = std::array<double, kMetricCount>;

struct Score {
    double total = 0.0;  // 0 to 100: the sum of the points
    MetricValues values{}, points{}, most_points{};
};
Score scoreOf(const MetricValues&) noexcept;

}  // namespace stylet::training
