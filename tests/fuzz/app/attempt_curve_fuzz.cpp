#include "app/report/attempt_files.h"
#include "tests/fuzz/parser_target.h"

// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    (void)stylet::report::parseCurve(input, "fuzz.csv");
}
