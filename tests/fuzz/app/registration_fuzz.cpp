#include "app/trainer/stores/registration_store.h"
#include "tests/fuzz/parser_target.h"

// An accepted registration survives a write and parse round trip unchanged.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet::trainer;
    const Registration taken = parseRegistration(input, "fuzz.json");
    const std::string text = registrationText(taken);
    if (registrationText(parseRegistration(text, "again.json")) != text) std::abort();
}
