#include "app/records/record.h"
#include "tests/fuzz/parser_target.h"

// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    (void)stylet::records::parseInfo(input, "fuzz.json");
}
