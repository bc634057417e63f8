// The tables of the study's page, and the words that stand in more than one of them.
#pragma once

#include <string>
#include <vector>

#include "app/study/report.h"

namespace stylet::study {

// "0.12 ± 0.04"; "–" where there is none.
std::string meanText(const Spread&, double unit, int digits);
std::size_t syntheticCount(const ReportedStudy&);
std::size_t steeredCount(const ReportedStudy&);  // patients in which a path was found

// Every figure of the paper's "Results" and what has become of it here.
report::Table paperTable(const ReportedStudy&);
report::Table patientTable(const ReportedStudy&);
report::Table borderTable(const ReportedStudy&);
report::Table tissueTable(const ReportedStudy&);
report::Table causeTable(const std::string& caption, const std::vector<CauseCount>&);
// The largest errors of paths that meet no bone, one row a path.
report::Table largestTable(const ReportedStudy&);
report::Table planTable(const ReportedStudy&);
report::Table labelTable(const ReportedStudy&);
report::Table thresholdTable(const ReportedStudy&);
report::Table forceTable(const PairFacts&, const std::string& caption);

}  // namespace stylet::study
