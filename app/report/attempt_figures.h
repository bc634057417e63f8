// The figures of one attempt, each with its numbers as a table and as a sentence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/report/attempt_files.h"
#include "app/report/page.h"

namespace stylet::report {

inline constexpr double kMmPerM = 1e3;

// What the force should have been: of the reference path, or of another attempt.
struct ReferenceCurve {
    std::string name;
    std::vector<FigurePoint> points;  // mm, N
};
// Along the path through the still patient, border to border (haptics/exact.h).
ReferenceCurve exactCurve(const patient::Patient&, const patient::PlannedPath&);
// The way in of another attempt.
ReferenceCurve curveOf(const AttemptFiles&);

struct DescribedFigure {
    Figure figure;
    std::string description, caption;
    Table data;
};

DescribedFigure forceFigure(const AttemptFiles&, const std::vector<ReferenceCurve>&);
// Tools, breath, tissue at the tip, faults as spans; what happened as points.
DescribedFigure timelineFigure(const AttemptFiles&);
// Depth, force, clearance and breath over time: a choice.
DescribedFigure courseFigure(const AttemptFiles&);

// Index into `course` of where the needle was deepest; none: it was never in the body.
std::optional<std::size_t> deepestRow(const std::vector<CourseRow>&);
// Where the target's duct was cut, else the deepest.
std::optional<std::size_t> tellingRow(const AttemptFiles&);

// The store's events; of a bare folder, what its summary knows.
std::vector<records::EventRow> eventsOf(const AttemptFiles&);
Table eventTable(const AttemptFiles&);
Table punctureTable(const AttemptFiles&);

}  // namespace stylet::report
