// The score: every metric of model.md section 9 in one table (the guide's metrics.md shows it too), and the
// total it gives. Pure functions.
//
// A metric earns its weight in full at its best value, nothing at its worst, a share of it between. What it
// earns counts in the share of the procedure that was done (metric "procedure"), so that who does nothing is
// not paid for having harmed nobody. So each part is visible, they add up to the total, and no metric that
// gets worse ever raises it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace stylet::training {

// In the table's order. Append, never insert: they are stored by id, but tests and reports count on the
// order.
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
    std::string_view id;    // in records and files
    std::string_view name;  // for people
    std::string_view unit;  // of value, best and worst; "" for counts
    std::string_view what;
    std::string_view source;
    double weight = 0.0;  // all add up to 100
    double best = 0.0, worst = 0.0;
};
std::span<const Metric> metricTable() noexcept;

// In the table's units and order. Not a number, and infinite on the wrong side: not achieved, so the worst.
using MetricValues = std::array<double, kMetricCount>;

struct Score {
    double total = 0.0;  // 0 to 100: the sum of the points
    MetricValues values{}, points{}, most_points{};
};
Score scoreOf(const MetricValues&) noexcept;

}  // namespace stylet::training
