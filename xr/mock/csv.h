// Recorded keys: a heading, then lines of numbers with commas, the first of which is a time.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "json_fields.h"

namespace xrmock {

using CsvFailure = std::function<void(const char* reason)>;  // throws FieldError with the line's number
using CsvRow = std::function<void(const std::vector<double>& numbers, const CsvFailure& fail)>;

// Calls `row` for each line of the file that the field names, which must open with the heading. Times grow
// strictly. Relative names are looked for in the folder.
void readCsv(const Field& field, const std::string& folder, const std::string& heading, const CsvRow& row);

}  // namespace xrmock
