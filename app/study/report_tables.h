// The tables of the study's page except the comparison with the paper, and texts that several tables share.
#pragma once

#include <string>
#include <vector>

#include "app/study/report.h"

namespace stylet::study {

// "0.12 ± 0.04"; "0.12" for a single value and "–" for none.
std::string meanText(const Spread&, double unit, int digits);
// 2 -> "2", 2.5 -> "2.5"
std::string numberText(double, int max_digits = 2);
// "skin, fascia"
std::string joined(const std::vector<std::string>&);
// "tenting at its border"
std::string eventText(haptics::NeedleEventKind);
// The labels of the built patient that the study compares: "all labels, as in training", or the four of the
// paper's Algorithm 1.
std::string comparedLabels(FoundLabels);
// The caption of a table of results: the text, and the labels compared.
std::string resultCaption(const std::string& text, const ReportedStudy&);
// "every skin voxel" or "skin voxels 2 mm apart", as requested when planning.
std::string voxelsText(const ReportedStudy&, double PlanFacts::* spacing_m, const std::string& kind);
double share(std::size_t part, std::size_t whole);  // none if `whole` is 0
bool isSynthetic(const PairFacts&);
std::size_t syntheticCount(const ReportedStudy&);
std::size_t steeredCount(const ReportedStudy&);  // patients with at least one path

report::Table patientTable(const ReportedStudy&);
report::Table borderTable(const ReportedStudy&);
report::Table tissueTable(const ReportedStudy&);
report::Table causeTable(const std::string& caption, const std::vector<CauseCount>&);
// The largest errors of the paths that meet no bone, one row per path.
report::Table largestTable(const ReportedStudy&);
report::Table planTable(const ReportedStudy&);
report::Table labelTable(const ReportedStudy&);
report::Table thresholdTable(const ReportedStudy&);
report::Table forceTable(const PairFacts&, const std::string& caption);

}  // namespace stylet::study
