// Runs the program with an OpenXR runtime other than the mock. Needs a headset that is worn, or a runtime
// that simulates one. Built only if CMake was given the runtime's manifest:
//     cmake --preset release -DSTYLET_OTHER_RUNTIME=/usr/share/openxr/1/openxr_monado.json
//     SIMULATED_ENABLE=1 XRT_COMPOSITOR_NULL=1 ctest --test-dir build/release -R other_runtime
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/trainer/command.h"

namespace stylet::trainer {
namespace {

using test::Outcome;
using testing::HasSubstr;
using testing::Not;

TEST(OtherRuntimeRunRealTime, ScriptedAttemptIsShownAndReplayed) {
    test::Command command;
    command.set("XR_RUNTIME_JSON", STYLET_OTHER_RUNTIME);
    const Outcome doctor = command.runBare("doctor");
    EXPECT_THAT(doctor.out, HasSubstr("runtime answers"));
    EXPECT_THAT(doctor.out, HasSubstr("shown, with the focus"));

    const Outcome attempt = command.run("run --no-mirror --mute --validation --spacing-mm 3");
    ASSERT_EQ(attempt.status, 0) << attempt.err;
    EXPECT_THAT(attempt.err, Not(HasSubstr("no pictures")));
    EXPECT_EQ(attempt.summary.at("target_hit"), true);
    EXPECT_GT(attempt.summary.at("frames"), 10);
    EXPECT_EQ(attempt.summary.at("validation_messages"), 0) << attempt.err;
    EXPECT_EQ(attempt.summary.at("headsets_found_again"), 0) << attempt.err;

    const Outcome again = command.run("replay --fast '" + (command.out() / "record").string() + "'");
    EXPECT_EQ(again.status, 0) << again.err;
    EXPECT_EQ(again.summary.at("state_hash"), attempt.summary.at("state_hash"));
}

}  // namespace
}  // namespace stylet::trainer
