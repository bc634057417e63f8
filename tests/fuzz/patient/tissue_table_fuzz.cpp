#include "patient/package/package_toml.h"
#include "tests/fuzz/parser_target.h"

// The result is a force table or a DataError.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet::patient;
    if (input.size() > kMaxTomlBytes) return;  // rejected before parsing
    parseTissueDefaults("fuzz.toml", input);
}
