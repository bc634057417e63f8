#include "app/training/patient_case.h"

#include <cmath>

#include "tests/fuzz/parser_target.h"

// The result is a case or a DataError. Whatever the case: a drainage never begins at once with clotting that
// must be corrected, except in an emergency, and every fact and reason has a text.
// HZ-RECORD-14
void fuzz::parse(std::string_view input) {
    using namespace stylet::training;
    const PatientCase c = parseCase(input, "fuzz.toml");
    if (rightAnswer(c, Question::begin) && rightAnswer(c, Question::clotting) &&
        c.urgency != Urgency::emergency)
        std::abort();
    if (!std::isfinite(c.inr + c.platelets_e9_per_l + c.last_dose_h)) std::abort();
    for (int i = 0; i < kQuestionCount; ++i)
        if (describeReason(c, Question(i)).empty()) std::abort();
    if (describeCase(c).size() < 2) std::abort();
}
