// Attempts as xAPI statements (IEEE 9274.1.1) for a training centre's learning record store. The file can
// be posted to the store's statements resource as it is. Every export of an attempt gives the same
// statements, so sending them twice is harmless. The trainee's pseudonym is the only personal data.
#pragma once

#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::report {

struct XapiSettings {
    // Base of the identities and activity names: an absolute http or https address without a trailing slash.
    std::string home = "https://stylet.invalid";
};

// Returns a JSON array: initialized; completed and passed or failed for finished attempts; terminated.
// Attempts without a trainee have no statements. Throws DataError if `home` is not a valid address.
std::string xapiStatements(const std::vector<records::StoredAttempt>&, const XapiSettings&);

// "PT1M3.25S"
std::string isoDuration(double seconds);

}  // namespace stylet::report
