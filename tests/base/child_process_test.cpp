#include "base/child_process_linux.h"

#include <gtest/gtest.h>

#include <csignal>

namespace stylet {
namespace {

using namespace std::chrono_literals;

ChildOutcome shell(const std::string& script, ChildSettings settings = {.timeout = 60s}) {
    return runProgram("/bin/sh", {"-c", script}, settings);
}

TEST(ChildProcess, ReturnsItsOutputAndStatus) {
    const ChildOutcome outcome = shell("echo one; echo two >&2; exit 3");
    EXPECT_TRUE(outcome.started);
    EXPECT_TRUE(outcome.in_time);
    EXPECT_EQ(outcome.text, "one\n");
    EXPECT_EQ(outcome.status, 3);
    EXPECT_FALSE(outcome.signal);
}

TEST(ChildProcess, ReturnsTheSignalThatEndedIt) {
    const ChildOutcome outcome = shell("kill -TERM $$");
    EXPECT_TRUE(outcome.in_time);
    EXPECT_EQ(outcome.signal, SIGTERM);
    EXPECT_FALSE(outcome.status);
}

TEST(ChildProcess, IsKilledAtTheDeadline) {
    for (const char* script : {"exec sleep 600", "exec sleep 600 >&-", "while :; do echo on; done"}) {
        const ChildOutcome outcome = shell(script, {.timeout = 300ms, .kill_timeout = 60s});
        EXPECT_TRUE(outcome.started) << script;
        EXPECT_FALSE(outcome.in_time) << script;
        EXPECT_EQ(outcome.signal, SIGKILL) << script;
    }
}

TEST(ChildProcess, DropsOutputBeyondTheLimit) {
    EXPECT_EQ(shell("echo 0123456789; echo more", {.timeout = 60s, .max_text_bytes = 4}).text, "0123");
}

TEST(ChildProcess, IsNotStartedIfTheProgramCannotBeExecuted) {
    EXPECT_FALSE(runProgram("/nonexistent/program", {}, {.timeout = 60s}).started);
    EXPECT_FALSE(runProgram("/", {}, {.timeout = 60s}).started);
}

TEST(ChildProcess, ObeysItsLimits) {
    const ResourceLimits limits{.cpu_s = 1, .memory_bytes = std::size_t(1) << 30, .file_bytes = 1 << 20};
    const ChildOutcome outcome = shell("ulimit -t; ulimit -n", {.timeout = 60s, .limits = limits});
    EXPECT_EQ(outcome.text, "1\n64\n");
    EXPECT_EQ(outcome.status, 0);
}

}  // namespace
}  // namespace stylet
