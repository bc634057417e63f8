// Attempts as xAPI statements (IEEE 9274.1.1), for a training centre's learning record store: a file to be
// posted, as it is, to its statements resource. Statements of one attempt are the same in every export, so
// sending them twice does no harm. Names nobody but the trainee's pseudonym.
#pragma once

#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::report {

struct XapiSettings {
    // What identities and activities are named under; an absolute http or https address without a trailing
    // slash.
    std::string home = "https://stylet.invalid";
};

// The least total of an attempt that counts as passed; it must have hit its target, too.
inline constexpr double kPassMark = 60.0;

// A JSON array: initialized; completed and passed or failed for attempts that are done; terminated.
// Attempts without a trainee have no statements, as they have nobody who did them. Throws patient::DataError
// for a home that is no address.
std::string xapiStatements(const std::vector<records::StoredAttempt>&, const XapiSettings&);

// "PT1M3.25S"
std::string isoDuration(double seconds);

}  // namespace stylet::report
