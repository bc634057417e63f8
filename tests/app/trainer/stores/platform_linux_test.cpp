#include "app/trainer/stores/platform_linux.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>

namespace stylet::trainer {
namespace {

// Replaces stdin by a pipe during a test.
struct Typing : testing::Test {
    void SetUp() override {
        std::array<int, 2> ends{};
        ASSERT_EQ(::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK), 0);
        stdin_ = ::dup(STDIN_FILENO);
        ::dup2(ends[0], STDIN_FILENO);
        ::close(ends[0]);
        in_ = ends[1];
    }
    void TearDown() override {
        if (stdin_ >= 0)
            ::dup2(stdin_, STDIN_FILENO), ::close(stdin_);
        else
            ::close(STDIN_FILENO);
        end();
    }
    // Writes until the pipe is full. Returns the number of bytes.
    std::size_t fill() const {
        const std::string line = "hold\n";
        std::size_t size = 0;
        while (::write(in_, line.data(), line.size()) == ssize_t(line.size()))
            size += line.size();
        return size;
    }
    void end() {
        if (in_ >= 0) ::close(in_);
        in_ = -1;
    }

  private:
    int stdin_ = -1, in_ = -1;
};

TEST_F(Typing, IsReadInPartsUntilTheEnd) {
    std::string text;
    EXPECT_TRUE(readTyped(text));
    EXPECT_EQ(text, "");
    const std::size_t size = fill();
    ASSERT_GT(size, 20'000u);
    EXPECT_TRUE(readTyped(text));
    EXPECT_LE(text.size(), 4096u) << "who types without end must not keep the caller";
    end();
    while (readTyped(text)) {
    }
    EXPECT_EQ(text.size(), size);
}

// An attempt reads only interrupted(). falcon_run_test.cpp shows that it then ends with zero force.
// HZ-FORCE-14
TEST(InterruptsDeathTest, SignalsOfATerminalAreCaughtAndReported) {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP}) {
        const auto interrupt = [signal] {
            catchInterrupts();
            const bool before = interrupted();
            raise(signal);
            std::_Exit(!before && interrupted() ? 7 : 1);
        };
        EXPECT_EXIT(interrupt(), testing::ExitedWithCode(7), "") << strsignal(signal);
    }
}

}  // namespace
}  // namespace stylet::trainer
