#include "patient/planning/paths_json.h"
#include "tests/fuzz/parser_target.h"

// The result is a list of paths or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    stylet::patient::parsePaths("fuzz.json", input);
}
