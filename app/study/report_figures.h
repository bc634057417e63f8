// The figures of the study's page, each with the table shown below it.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/study/report.h"

namespace stylet::study {

struct Plot {
    report::Figure figure;
    report::Table numbers;
    std::size_t beyond = 0;  // values above the axis
};

// A number that each path has.
struct PathNumber {
    std::string axis;  // "RMSE, N"
    int digits = 3;
    double unit = 1.0;  // scale from the value to the axis unit
    const Spread& (*spread)(const Summary&);
    double (*value)(const PathResult&);
    std::vector<double> thresholds{};  // in the axis unit
};

// One box per patient and one for all paths, as in Figs. 6-8 of the paper.
Plot boxPlot(const ReportedStudy&, const PathNumber&);

// Mean and standard deviation per tissue border, for all patients and for each selectable patient, as in
// Figs. 4 and 5. Tissues that hardly any path meets are left out.
Plot borderPlot(const ReportedStudy&, const std::string& axis, const Spread& (*spread)(const TissueSummary&),
                const std::vector<double>& thresholds_mm);

// RMSE by position along the path from the skin to the target.
Plot positionPlot(const ReportedStudy&);

// Histograms of C3, C4 and Q over the kept paths.
Plot scorePlot(const ReportedStudy&);

// 31222 -> "31,222"
std::string countText(std::size_t);
// Returns "–" for no value.
std::string percentText(double share, int digits = 1);

}  // namespace stylet::study
