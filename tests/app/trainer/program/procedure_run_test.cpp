// Runs the whole procedure through the program with a recorded motion trace as input.
#include <gtest/gtest.h>

#include "tests/app/trainer/program/kept_attempt.h"

namespace stylet::trainer {
namespace {

using test::KeptAttempt;
using test::Outcome;

const std::string kProcedureRun = "run --fast --spacing-mm 3 --seed 4 --scenario procedure --trainee ";

// The scenario provides the commands, and the trace provides the motion. Together they reproduce the attempt.
TEST(ProcedureRun, WholeProcedureFromAHapticTrace) {
    test::Command command;
    const Outcome scripted = command.runBare(kProcedureRun + "script");
    const KeptAttempt first = test::checkStoredAttempt(command, scripted, "script");
    test::expectWholeProcedure(first);
    EXPECT_GT(first.stored.result->total, 85.0);

    const std::filesystem::path hand = command / "hand.csv";
    const Outcome saved = command.run("replay --fast '" + (first.stored.folder / "record").string() +
                                      "' --save-hand '" + hand.string() + "'");
    ASSERT_EQ(saved.status, 0) << saved.err;
    const Outcome traced =
        command.runBare(kProcedureRun + "hand --device replay --trace '" + hand.string() + "'");
    const KeptAttempt second = test::checkStoredAttempt(command, traced, "hand");
    test::expectWholeProcedure(second);
    EXPECT_EQ(second.stored.info.device, "replay");
    EXPECT_EQ(second.summary.at("state_hash"), first.summary.at("state_hash"));
    EXPECT_EQ(second.stored.result->total, first.stored.result->total);
    EXPECT_EQ(second.felt_n, first.felt_n);
}

}  // namespace
}  // namespace stylet::trainer
