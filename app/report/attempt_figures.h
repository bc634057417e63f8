// The figures of one attempt, each with its numbers as a table and a sentence that describes it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/report/attempt_files.h"
#include "app/report/page.h"

namespace stylet::report {

inline constexpr double kMmPerM = 1e3;

// A force curve to compare with, from the reference path or from another attempt.
struct ReferenceCurve {
    std::string name;
    std::vector<FigurePoint> points;  // mm, N
};
// The exact force along the path through the patient at rest, border by border (haptics/tools/exact.h).
// `needle`: force settings of the attempt's needle.
ReferenceCurve exactCurve(const patient::Patient&, const patient::PlannedPath&,
                          const haptics::NeedleSettings& needle);
// The insertion of another attempt.
ReferenceCurve insertionCurve(const LoadedAttempt&);

DescribedFigure forceFigure(const LoadedAttempt&, const std::vector<ReferenceCurve>&);
// Tools, breath, tissue at the tip and faults as spans; events as points.
DescribedFigure timelineFigure(const LoadedAttempt&);
// True if such a timeline has a span or an event outside the row of tools.
bool showsMoreThanTools(const Figure& timeline);
// Depth, force, clearance and breath over time; the reader selects one.
DescribedFigure courseFigure(const LoadedAttempt&);

// Index into `course` of the deepest needle position; none if the needle was never in the body.
std::optional<std::size_t> deepestRow(const std::vector<CourseRow>&);
// The row at which the target duct was cut, else the deepest row.
std::optional<std::size_t> keyRow(const LoadedAttempt&);

Table eventTable(const LoadedAttempt&);
Table punctureTable(const LoadedAttempt&);
Table caseTable(const LoadedAttempt&);  // answers to the questions about the case; no rows without a case

}  // namespace stylet::report
