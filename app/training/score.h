// The score: the metrics of metric_table.h and their total. Pure functions.
//
// A metric earns its full weight at its best value, nothing at its worst, and a linear share between. All
// points are then scaled by the completed share of the procedure (metric "procedure"), and a metric earns
// nothing before the step that it belongs to is done (Metric::needs). So an idle trainee earns no points for
// harming nobody. Each part is visible, the parts add up to the total, and a metric that gets worse never
// raises the total.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "app/training/metric_table.h"

namespace stylet::training {

std::span<const Metric> metricTable() noexcept;

// In the table's order and units. NaN, or infinity in the direction of the worst value, means "not achieved"
// and scores as the worst value.
using MetricValues = std::array<double, kMetricCount>;

struct Score {
    Course course = kDefaultCourse;
    bool has_case = true;
    double total = 0.0;  // 0 to 100: the sum of the points
    MetricValues values{}, points{}, max_points{};
};
// `steps_done`: bit mask of 1 << Step. The weights of a longer course are scaled so that their sum is 100.
// `has_case`: false for a drainage recorded before there were cases; its review is not scored. A metric that
// does not count in this attempt has max_points of 0.
Score computeScore(const MetricValues&, std::uint32_t steps_done, Course course = kDefaultCourse,
                   bool has_case = true) noexcept;

// A part without which an exam of a course is failed whatever the total: at least one of the steps `any_of`
// (bit mask) must be done.
struct ExamPart {
    Course course = kDefaultCourse;
    std::uint32_t any_of = 0;
    std::string_view name;
};
// Based on the CIRSE Standards of Practice (Das et al. 2021) and the guidelines of the SIR (Saad et al.
// 2010): a cholangiography is a puncture under imaging and a picture of the ducts; a drainage also needs
// local anaesthesia, a proven access, a dilated track, a drain that drains, and a picture of its place.
// Palpation, incision and needle guide serve these ends: without them an exam loses points (metrics.cpp).
constexpr std::uint32_t maskOf(auto... steps) noexcept {
    return (... | (1u << unsigned(steps)));
}
inline constexpr std::array kExamParts{
    ExamPart{Course::puncture, maskOf(Step::advance), "the puncture of the duct under ultrasound"},
    ExamPart{Course::puncture, maskOf(Step::contrast), "the picture of the ducts"},
    ExamPart{Course::drainage, maskOf(Step::anaesthetise), "local anaesthesia"},
    ExamPart{Course::drainage, maskOf(Step::advance), "the puncture of the duct under ultrasound"},
    ExamPart{Course::drainage, maskOf(Step::aspirate, Step::contrast),
             "the proof that the needle is in a duct, by bile or contrast medium"},
    ExamPart{Course::drainage, maskOf(Step::dilate), "the dilated track"},
    ExamPart{Course::drainage, maskOf(Step::drain), "the drain with its side holes in the ducts"},
    ExamPart{Course::drainage, maskOf(Step::finalPicture), "the final picture"},
};
constexpr bool isMissing(const ExamPart& part, Course course, std::uint32_t steps_done) noexcept {
    return part.course == course && (part.any_of & steps_done) == 0;
}
// Names, in the order of kExamParts.
std::vector<std::string_view> missingParts(Course, std::uint32_t steps_done);

// An exam is passed with this total, every part of its course, and no critical error.
inline constexpr double kPassMark = 60.0;
constexpr bool passesExam(const Progress& progress) noexcept {
    return progress.total >= kPassMark && progress.critical_errors == 0 &&
           std::ranges::none_of(kExamParts, [&](const ExamPart& part) {
               return isMissing(part, progress.course, progress.steps_done);
           });
}

}  // namespace stylet::training
