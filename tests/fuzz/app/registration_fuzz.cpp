#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "app/trainer/stores/registration_store.h"
#include "patient/package/package.h"

// An accepted registration survives a write and parse round trip unchanged.
// HZ-RECORD-14
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stylet::trainer;
    try {
        const Registration taken =
            parseRegistration({reinterpret_cast<const char*>(data), size}, "fuzz.json");
        const std::string text = registrationText(taken);
        if (registrationText(parseRegistration(text, "again.json")) != text) std::abort();
    } catch (const stylet::DataError&) {
    }
    return 0;
}
