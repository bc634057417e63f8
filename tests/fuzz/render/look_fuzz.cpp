#include "render/volume/look.h"
#include "tests/fuzz/parser_target.h"

// The result is a look or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    stylet::render::parseLook("fuzz.toml", input);
}
