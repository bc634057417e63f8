#include "render/ultrasound/transducer.h"
#include "tests/fuzz/parser_target.h"

// The result is a transducer or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    stylet::render::parseTransducer("fuzz.toml", input);
}
