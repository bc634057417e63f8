// The study beside its paper: every figure of its "Results", what has become of it here, and why. What is
// said follows the numbers of the study at hand.
#pragma once

#include "app/study/report.h"

namespace stylet::study {

report::Table paperTable(const ReportedStudy&);

}  // namespace stylet::study
