#include "app/trainer/stores/platform_linux.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
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

// XDG Base Directory Specification: a relative path in one of its variables is invalid and ignored.
TEST(UserFolders, IgnoreVariablesWithARelativePath) {
    const char* const names[] = {"HOME", "XDG_CACHE_HOME", "XDG_DATA_HOME"};
    std::map<std::string, std::optional<std::string>> before;
    for (const char* name : names)
        if (const char* value = std::getenv(name))
            before[name] = value;
        else
            before[name] = std::nullopt;
    setEnvironment("HOME", "/home/x");
    setEnvironment("XDG_CACHE_HOME", "cache"), setEnvironment("XDG_DATA_HOME", "./data");
    EXPECT_EQ(cacheFolder(), "/home/x/.cache/stylet");
    EXPECT_EQ(dataFolder(), "/home/x/.local/share/stylet");
    EXPECT_FALSE(isDataTemporary());
    setEnvironment("HOME", "x");
    EXPECT_EQ(dataFolder(), std::filesystem::temp_directory_path() / "stylet");
    EXPECT_TRUE(isDataTemporary());
    setEnvironment("XDG_DATA_HOME", "/data");
    EXPECT_EQ(dataFolder(), "/data/stylet");
    EXPECT_FALSE(isDataTemporary());
    for (const auto& [name, value] : before)
        if (value)
            setEnvironment(name.c_str(), *value);
        else
            unsetenv(name.c_str());
}

// The kernel stops a background job that reads from its terminal.
TEST(Terminal, IsNotReadInTheBackground) {
    const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    ASSERT_GE(terminal, 0);
    ASSERT_EQ(::grantpt(terminal), 0);
    ASSERT_EQ(::unlockpt(terminal), 0);
    const std::string name = ::ptsname(terminal);
    ASSERT_EQ(::write(terminal, "hold\n", 5), 5);
    const pid_t shell = ::fork();
    ASSERT_GE(shell, 0);
    if (shell == 0) {  // leads a session whose terminal is the new one
        ::setsid();
        ::dup2(::open(name.c_str(), O_RDWR), STDIN_FILENO);
        const pid_t job = ::fork();
        std::string text;
        if (job == 0) {
            ::setpgid(0, 0);
            std::_Exit(readTyped(text) && text.empty() ? 7 : 1);
        }
        int status = 0;
        ::waitpid(job, &status, WUNTRACED);
        if (WIFSTOPPED(status)) ::kill(job, SIGKILL);
        const bool skipped = WIFEXITED(status) && WEXITSTATUS(status) == 7;
        std::_Exit(skipped && readTyped(text) && text == "hold\n" ? 7 : 1);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(shell, &status, 0), shell);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 7) << status;
    ::close(terminal);
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
