// The commands of `stylet-report`.
#pragma once

#include <filesystem>
#include <string>

#include "app/report/xapi.h"

namespace stylet::report {

struct ReportOptions {
    std::filesystem::path records;  // empty: $XDG_DATA_HOME/stylet/records
    std::filesystem::path out;
    std::string attempt, reference;  // id or folder
    std::filesystem::path patient;
    bool cohort = false;  // compare the attempt with those of the store
    std::string trainee, scenario;
    XapiSettings xapi;
};

// Each command writes a page, its tables as CSV and, if there are trainees, xapi.json. Returns the path of
// the page. Throws DataError.
std::filesystem::path reportAttempt(const ReportOptions&);
std::filesystem::path reportTrainee(const ReportOptions&);
std::filesystem::path reportCohort(const ReportOptions&);

}  // namespace stylet::report
