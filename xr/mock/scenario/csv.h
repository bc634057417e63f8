// Recorded keys as CSV: a heading, then lines of comma-separated numbers, of which the first is the time.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenario/json_fields.h"

namespace xrmock {

using CsvFailure = std::function<void(const char* reason)>;  // throws FieldError with the line's number
using CsvRow = std::function<void(const std::vector<double>& numbers, const CsvFailure& fail)>;

// Reads the file named by the field and calls `row` for each line after the heading, which must match.
// Times must increase strictly. Relative file names are resolved against `folder`.
void readCsv(const Field& field, const std::string& folder, const std::string& heading, const CsvRow& row);

}  // namespace xrmock
