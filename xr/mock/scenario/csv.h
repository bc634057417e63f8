// Reads recorded values of a scenario from a CSV file. The first line is a heading. Each further line
// contains comma-separated numbers; the first number is the time in seconds.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenario/json_fields.h"

namespace xrmock {

using CsvFailure = std::function<void(const char* reason)>;  // throws FieldError with the line's number
using CsvRow = std::function<void(const std::vector<double>& numbers, const CsvFailure& fail)>;

// Reads the file named by `field` and calls `row` once for each line below the heading. The file's first line
// must equal `heading`. The times must increase from line to line. A relative file name is resolved against
// `folder`.
void readCsv(const Field& field, const std::string& folder, const std::string& heading, const CsvRow& row);

}  // namespace xrmock
