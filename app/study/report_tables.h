// The tables of the study's page but the one beside the paper, and the words that stand in more than one.
#pragma once

#include <string>
#include <vector>

#include "app/study/report.h"

namespace stylet::study {

// "0.12 ± 0.04"; "–" where there is none.
std::string meanText(const Spread&, double unit, int digits);
// 2 -> "2", 2.5 -> "2.5"
std::string numberText(double);
// "skin, fascia"
std::string joined(const std::vector<std::string>&);
// "held at its border"
std::string eventText(haptics::NeedleEventKind);
// "every skin voxel", "skin voxels 2 mm apart", as planned
std::string voxelsText(const ReportedStudy&, double PlanFacts::* spacing_m, const std::string& kind);
double share(std::size_t part, std::size_t whole);  // none of nothing
bool isSynthetic(const PairFacts&);
std::size_t syntheticCount(const ReportedStudy&);
std::size_t steeredCount(const ReportedStudy&);  // patients in which a path was found

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
