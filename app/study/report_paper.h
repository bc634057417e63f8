// The table that compares the study with the paper: every number of its section "Results", the value found
// here, and the reason for the difference. The texts depend on the study's numbers.
#pragma once

#include "app/study/report.h"

namespace stylet::study {

report::Table paperTable(const ReportedStudy&);

}  // namespace stylet::study
