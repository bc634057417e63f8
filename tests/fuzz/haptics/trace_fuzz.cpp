#include "haptics/devices/replay.h"
#include "tests/fuzz/parser_target.h"

// The result is a trace or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    stylet::haptics::parseTrace("fuzz.csv", input);
}
