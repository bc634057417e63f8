#include "render/ultrasound/acoustics.h"
#include "tests/fuzz/parser_target.h"

// The result is an acoustic table or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    stylet::render::parseAcoustics("fuzz.toml", input);
}
