#include "app/modeller/image/child_process_linux.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <thread>

namespace stylet::modeller {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestSentence = 1000;

void limit(decltype(RLIMIT_CPU) what, std::size_t value) {
    const rlimit r{value, value};
    setrlimit(what, &r);
}

// Runs in the child between fork and exec: only async-signal-safe calls are allowed.
[[noreturn]] void becomeChild(const char* const* argv, int say, const ChildLimits& limits) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    setpgid(0, 0);  // Ctrl-C must reach only the parent
    signal(SIGPIPE, SIG_DFL);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    limit(RLIMIT_AS, limits.memory_bytes);
    limit(RLIMIT_CPU, std::size_t(limits.cpu_s));
    limit(RLIMIT_FSIZE, limits.file_bytes);
    limit(RLIMIT_NOFILE, 64);
    limit(RLIMIT_CORE, 0);
    const int quiet = open("/dev/null", O_RDWR);
    dup2(quiet, STDIN_FILENO);
    dup2(say, STDOUT_FILENO);
    dup2(quiet, STDERR_FILENO);
    execv(argv[0], const_cast<char* const*>(argv));
    _exit(127);
}

using Clock = std::chrono::steady_clock;

// Reads until the child closes its output. Returns false if the deadline passes first.
bool listen(int pipe, Clock::time_point deadline, std::string& said) {
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left.count() <= 0) return false;
        pollfd wait_for{pipe, POLLIN, 0};
        const int ready = poll(&wait_for, 1, int(left.count()));
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        if (ready < 0) return true;
        char text[512];
        const ssize_t n = read(pipe, text, sizeof text);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return true;
        if (said.size() < 2048) said.append(text, std::size_t(n));
    }
}

// Waits until the child has ended. Returns false if the deadline passes first.
bool ended(pid_t child, Clock::time_point deadline, int& status) {
    for (;;) {
        const pid_t who = waitpid(child, &status, WNOHANG);
        if (who == child) return true;
        if (who < 0 && errno != EINTR) throw ImportError("a child process is lost");
        if (Clock::now() >= deadline) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

struct ChildEnd {
    int status = 0;
    bool timed_out = false;
    std::string said;
};

ChildEnd waitFor(const char* const* argv, const ChildLimits& limits) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw ImportError("no pipe to " + std::string(argv[0]));
    const auto deadline = Clock::now() + std::chrono::seconds(limits.wall_s);
    const pid_t child = fork();
    if (child == 0) becomeChild(argv, ends[1], limits);
    close(ends[1]);
    if (child < 0) {
        close(ends[0]);
        throw ImportError(std::string(argv[0]) + " cannot be started");
    }
    ChildEnd end;
    const bool silent = listen(ends[0], deadline, end.said);
    close(ends[0]);
    end.timed_out = !silent || !ended(child, deadline, end.status);
    if (end.timed_out) {
        kill(child, SIGKILL);
        while (waitpid(child, &end.status, 0) < 0 && errno == EINTR) {
        }
    }
    return end;
}

// Cleans the child's output for display: one printable line, at most as long as a list of series.
std::string tidy(const std::string& said) {
    std::string out;
    for (char c : said) {
        if (c == '\n' || out.size() == kLongestSentence) break;
        out += c >= 32 && c < 127 ? c : '?';
    }
    return out;
}

std::string reasonOf(const ChildEnd& end, const ChildLimits& limits, const std::string& who) {
    if (end.timed_out) return who + " was stopped after " + std::to_string(limits.wall_s) + " s";
    if (WIFSIGNALED(end.status)) {
        if (WTERMSIG(end.status) == SIGXCPU || WTERMSIG(end.status) == SIGKILL)
            return who + " was stopped at its limit of " + std::to_string(limits.cpu_s) + " s of work";
        return "the file crashed " + who + " (" + strsignal(WTERMSIG(end.status)) + ")";
    }
    const std::string said = tidy(end.said);
    return said.empty() ? who + " gave up without a word" : said;
}

}  // namespace

PrivateFolder::PrivateFolder() {
    std::string name = (fs::temp_directory_path() / "stylet-import-XXXXXX").string();
    if (!mkdtemp(name.data())) throw ImportError("no temporary folder can be made in " + name);
    path_ = name;
}

PrivateFolder::~PrivateFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
}

fs::path childProgram(const fs::path& given, const std::string& name) {
    if (!given.empty()) {
        if (access(given.c_str(), X_OK) != 0) throw ImportError(given.string() + ": the program is missing");
        return given;
    }
    // In a build tree it is next to this program; when installed, it is in libexec.
    std::error_code error;
    const fs::path bin = fs::read_symlink("/proc/self/exe", error).parent_path();
    for (const fs::path& program : {bin / name, bin.parent_path() / "libexec" / "stylet" / name})
        if (access(program.c_str(), X_OK) == 0) return program;
    throw ImportError((bin / name).string() + ": the program is missing (it is built with STYLET_ITK=ON)");
}

void runChild(const fs::path& program, const std::vector<std::string>& arguments, const ChildLimits& limits,
              const std::string& about, const std::string& who) {
    std::vector<const char*> argv{program.c_str()};
    for (const std::string& argument : arguments)
        argv.push_back(argument.c_str());
    argv.push_back(nullptr);
    const ChildEnd end = waitFor(argv.data(), limits);
    if (end.timed_out || !WIFEXITED(end.status) || WEXITSTATUS(end.status) != 0)
        throw ImportError(about + ": " + reasonOf(end, limits, who));
}

}  // namespace stylet::modeller
