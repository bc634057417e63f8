#include "patient/package/verdict.h"
#include "tests/fuzz/parser_target.h"

// The result is a verdict or a DataError.
// HZ-TEACH-22
void fuzz::parse(std::string_view input) {
    stylet::patient::parseVerdict("fuzz.json", input);
}
