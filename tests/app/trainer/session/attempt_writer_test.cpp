#include "app/trainer/session/attempt_writer.h"

#include <gtest/gtest.h>

#include "tests/app/records/some_result.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

records::AttemptResult resultOf(bool hit, double procedure, bool aborted) {
    records::AttemptResult result = test::someResult();
    result.target_hit = hit, result.aborted = aborted;
    result.metrics = {{"procedure", "Procedure done", "%", procedure, 1.0, 8.0}};
    return result;
}

// A trainee is guided until it has completed a guided attempt itself.
TEST(AttemptWriter, GuidesUntilOneGuidedAttemptWasCompleted) {
    struct Case {
        const char *device, *difficulty;
        bool hit;
        double procedure;
        bool aborted, guides;  // afterwards
    };
    for (const Case& c :
         {Case{"mouse", "guided", true, 60.0, false, true}, Case{"mouse", "guided", true, 80.0, false, false},
          Case{"controllers", "guided", false, 100.0, false, false},
          Case{"mouse", "guided", false, 50.0, false, true}, Case{"mouse", "guided", true, 100.0, true, true},
          Case{"mouse", "practice", true, 100.0, false, true},
          Case{"scripted", "guided", true, 100.0, false, true},
          Case{"replay", "guided", true, 100.0, false, true}}) {
        const test::TempFolder folder;
        {
            records::Store store(folder / "s");
            records::AttemptInfo info;
            info.trainee = "anna", info.device = c.device, info.difficulty = c.difficulty;
            test::finish(store, store.begin(info), resultOf(c.hit, c.procedure, c.aborted));
        }
        const AttemptWriter writer(folder / "s", "", [](const std::string&) {});
        EXPECT_EQ(writer.needsGuidance("anna"), c.guides)
            << c.device << ' ' << c.difficulty << ' ' << c.hit << ' ' << c.procedure << ' ' << c.aborted;
        EXPECT_TRUE(writer.needsGuidance("bert"));
    }
}

// Otherwise the last bookmark of another person's guided attempt would be enough.
TEST(AttemptWriter, ARestartedAttemptSpendsNoGuidance) {
    const test::TempFolder folder;
    {
        records::Store store(folder / "s");
        records::AttemptInfo info;
        info.trainee = "anna", info.device = "mouse", info.difficulty = "guided";
        test::finish(store, store.begin(info), resultOf(true, 100.0, false),
                     {{0, "retry", "another attempt until bookmark 2"}});
    }
    const AttemptWriter writer(folder / "s", "", [](const std::string&) {});
    EXPECT_TRUE(writer.needsGuidance("anna"));
}

TEST(AttemptWriter, AnUnfinishedAttemptSpendsNoGuidance) {
    const test::TempFolder folder;
    {
        records::Store store(folder / "s");
        records::AttemptInfo info;
        info.trainee = "anna", info.device = "mouse", info.difficulty = "guided";
        test::writeUnfinishedRecord(store.attempt(store.begin(info)), 300);
    }
    const AttemptWriter writer(folder / "s", "", [](const std::string&) {});
    EXPECT_TRUE(writer.needsGuidance("anna"));
}

}  // namespace
}  // namespace stylet::trainer
