// The figures of the study's page, each with the table that stands beneath it.
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

// One number of each path.
struct PathNumber {
    std::string axis;  // "RMSE, N"
    int digits = 3;
    double unit = 1.0;  // of the axis
    const Spread& (*spread)(const Summary&);
    double (*value)(const PathResult&);
    std::vector<double> thresholds{};  // in the axis' unit
};

// A box each patient and one of all paths, as Figs. 6-8 of the paper.
Plot boxPlot(const ReportedStudy&, const PathNumber&);

// Mean and deviation of each tissue's borders, of all and of each patient by choice, as Figs. 4 and 5;
// without those that hardly a path meets.
Plot borderPlot(const ReportedStudy&, const std::string& axis, const Spread& (*spread)(const TissueSummary&),
                const std::vector<double>& thresholds_mm);

// RMSE along the way from the skin to the target.
Plot positionPlot(const ReportedStudy&);

// Histograms of C3, C4 and Q over the kept paths.
Plot scorePlot(const ReportedStudy&);

// 31222 -> "31,222"
std::string countText(std::size_t);
// "–" where there is none.
std::string percentText(double share, int digits = 1);

}  // namespace stylet::study
