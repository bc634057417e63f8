// Made-up attempts, as a store returns them.
#pragma once

#include <string>
#include <vector>

#include "app/records/store.h"

namespace stylet::test {

// Text with markup that must appear as plain text in every output.
inline const std::string kHostile =
    "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'&\xFF\x01";

inline records::StoredAttempt makeTestAttempt(const std::string& id, const std::string& trainee, double total,
                                              bool hit) {
    records::StoredAttempt a;
    a.id = id;
    a.info.trainee = trainee;
    a.info.device = "scripted";
    a.info.patient = "reference patient, seed 7";
    a.info.scenario = "procedure";
    a.info.difficulty = "practice";
    a.info.program_version = "0.1.0";
    a.info.seed = 7;
    a.info.patient_digest = 0xfeedfacecafebeefULL;
    a.info.registration_rms_m = 0.0012;
    a.started_utc = "2026-11-20T23:59:30.500Z";
    a.state = records::AttemptState::done;
    records::AttemptResult result;
    result.target_hit = hit;
    result.total = total;
    result.ticks = 63250;
    result.metrics = {
        {"targeting", "Tip to target", "mm", 20.0 - total / 5.0, 0.2 * total, 20.0},
        {"risk_hits", "Risk structures struck", "", total > 50.0 ? 0.0 : 2.0, 0.3 * total, 30.0},
        {"session_time", "Session time", "s", 63.25, 0.5 * total, 50.0}};
    result.steps = {"advance to the duct", {}, 6, 0};
    if (hit) result.steps.done.emplace_back("advance to the duct");
    a.result = result;
    a.events = {{0, "tool", "finger"},          {2000, "contact", "finger on the skin"},
                {9000, "step", "find the gap"}, {31000, "near_miss", "1.4 mm from the portal vein"},
                {32000, "risk", "portal vein"}, {41000, "cut", "bile ducts at 1.20 N"},
                {50000, "comment", kHostile}};
    if (hit) a.events.insert(a.events.end() - 1, {41000, "step", "advance to the duct"});
    return a;
}

// Six trainees with four to six attempts each. They improve at different rates.
inline std::vector<records::StoredAttempt> makeTestCohort() {
    std::vector<records::StoredAttempt> all;
    for (int trainee = 0; trainee < 6; ++trainee)
        for (int n = 0; n < 4 + trainee % 3; ++n) {
            const double total =
                std::min(96.0, 31.0 + 7.5 * trainee + (6.0 + trainee) * n - (n == 2 ? 9.0 : 0.0));
            all.push_back(makeTestAttempt("t" + std::to_string(trainee) + "-" + std::to_string(n),
                                          "trainee-" + std::string(1, char('A' + trainee)), total,
                                          total > 45.0));
        }
    all.push_back(makeTestAttempt("short", "trainee-B", 0.0, false));
    all.back().state = records::AttemptState::cut_short;
    all.back().result.reset();
    return all;
}

}  // namespace stylet::test
