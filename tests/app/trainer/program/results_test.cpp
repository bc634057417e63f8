// Which attempts may be kept out of the statistics because nothing happened in them.
#include "app/trainer/program/results.h"

#include <gtest/gtest.h>

namespace stylet::trainer {
namespace {

SessionLog idleLog() {
    SessionLog log;
    log.events = {{0, "tool", "needle"},
                  {5, "contact", "finger on the skin"},
                  {6, "contact", "probe on the skin"},
                  {7, "breath", "held"},
                  {8, "fault", "late tick"}};
    return log;
}

TEST(Results, PalpatingAndScanningReachNothing) {
    EXPECT_TRUE(reachedNothing(idleLog(), false));
    EXPECT_TRUE(reachedNothing(idleLog(), true));
}

TEST(Results, EverythingThatTheScoreCountsIsSomething) {
    for (const training::SessionEvent& event :
         std::vector<training::SessionEvent>{{9, "refused", "the incision is not at the entry"},
                                             {9, "contact", "needle on the skin"},
                                             {9, "contact", "scalpel on the skin"},
                                             {9, "cut", "skin at 0.1 mm"},
                                             {9, "risk", "vessel at 30.0 mm"},
                                             {9, "near_miss", "passed a risk structure at 1.0 mm"},
                                             {9, "critical", "the lung was punctured"},
                                             {9, "pain", "8 of 10: incision"},
                                             {9, "step", "find the duct"}}) {
        SessionLog log = idleLog();
        log.events.push_back(event);
        EXPECT_FALSE(reachedNothing(log, false)) << event.kind << ' ' << event.text;
        EXPECT_FALSE(reachedNothing(log, true)) << event.kind << ' ' << event.text;
    }
    for (double training::DoseLedger::* dose :
         {&training::DoseLedger::fluoroscopy_s, &training::DoseLedger::contrast_m3,
          &training::DoseLedger::anaesthetic_m3}) {
        SessionLog log = idleLog();
        log.dose.*dose = 1e-6;
        EXPECT_FALSE(reachedNothing(log, false));
    }
}

// In practice a trainee may leave after the review; in an exam the answers are part of the result.
TEST(Results, AnswersAreSomethingInAnExamOnly) {
    for (const training::SessionEvent& event : std::vector<training::SessionEvent>{
             {9, "answer", "wrong"}, {9, "step", std::string(stepName(training::Step::reviewCase))}}) {
        SessionLog log = idleLog();
        log.events.push_back(event);
        EXPECT_TRUE(reachedNothing(log, false)) << event.kind;
        EXPECT_FALSE(reachedNothing(log, true)) << event.kind;
    }
}

}  // namespace
}  // namespace stylet::trainer
