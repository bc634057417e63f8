#include "base/child_process_linux.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <thread>

namespace stylet {
namespace {

using ChildClock = std::chrono::steady_clock;

struct Pipe {
    int read_end = -1, write_end = -1;
    Pipe() {
        std::array<int, 2> ends{};
        if (pipe2(ends.data(), O_CLOEXEC) == 0) read_end = ends[0], write_end = ends[1];
    }
    ~Pipe() {
        closeWriting();
        if (read_end >= 0) close(read_end);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;
    void closeWriting() {
        if (write_end >= 0) close(write_end);
        write_end = -1;
    }
};

void limitResource(decltype(RLIMIT_CPU) resource, std::size_t value) {
    const rlimit r{value, value};
    setrlimit(resource, &r);
}

void applyLimits(const ResourceLimits& limits) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    limitResource(RLIMIT_AS, limits.memory_bytes);
    limitResource(RLIMIT_CPU, std::size_t(limits.cpu_s));
    limitResource(RLIMIT_FSIZE, limits.file_bytes);
    limitResource(RLIMIT_NOFILE, 64);
    limitResource(RLIMIT_CORE, 0);
}

// Runs in the child between fork and exec: only async-signal-safe calls are allowed. Writes a byte to
// `failure` if the program cannot be executed.
[[noreturn]] void execInChild(const char* const* argv, int out, int failure, const ResourceLimits* limits) {
    setpgid(0, 0);
    std::signal(SIGPIPE, SIG_DFL);  // the caller may ignore it; a program expects the default
    if (limits) applyLimits(*limits);
    const int quiet = open("/dev/null", O_RDWR);
    dup2(quiet, STDIN_FILENO);
    dup2(out, STDOUT_FILENO);
    dup2(quiet, STDERR_FILENO);
    execv(argv[0], const_cast<char* const*>(argv));
    if (write(failure, "!", 1) != 1) _exit(126);
    _exit(127);
}

// Waits until the child has executed its program. Returns false if it could not.
bool waitForExec(int failure) {
    char byte = 0;
    ssize_t count = 0;
    while ((count = read(failure, &byte, 1)) < 0 && errno == EINTR) {
    }
    return count <= 0;
}

// Reads until the child closes its output. Returns false if the deadline passes first.
bool readUntil(int pipe, ChildClock::time_point deadline, std::size_t max_bytes, std::string& text) {
    for (;;) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - ChildClock::now());
        if (left.count() <= 0) return false;
        pollfd wait_for{pipe, POLLIN, 0};
        const int ready = poll(&wait_for, 1, int(left.count()));
        if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
        if (ready < 0) return true;
        std::array<char, 4096> bytes{};
        const ssize_t count = read(pipe, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return true;
        text.append(bytes.data(), std::min(std::size_t(count), max_bytes - text.size()));
    }
}

// Polls until the child ends or the deadline passes. A blocking wait could hang forever on a process that is
// stuck in the kernel. Returns false if the deadline passes first. `status` is not set if another call has
// already waited for the child.
bool hasEnded(pid_t child, ChildClock::time_point deadline, std::optional<int>& status) {
    for (;;) {
        int value = 0;
        const pid_t ended = waitpid(child, &value, WNOHANG);
        if (ended == child) status = value;
        if (ended == child || (ended < 0 && errno != EINTR)) return true;
        if (ChildClock::now() >= deadline) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

}  // namespace

ChildOutcome runProgram(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                        const ChildSettings& settings) {
    ChildOutcome outcome;
    const auto deadline = ChildClock::now() + settings.timeout;
    std::vector<const char*> argv{program.c_str()};
    for (const std::string& argument : arguments)
        argv.push_back(argument.c_str());
    argv.push_back(nullptr);
    Pipe out, failure;
    if (out.write_end < 0 || failure.write_end < 0) return outcome;
    const pid_t child = fork();
    if (child == 0)
        execInChild(argv.data(), out.write_end, failure.write_end,
                    settings.limits ? &*settings.limits : nullptr);
    out.closeWriting();
    failure.closeWriting();
    if (child < 0) return outcome;
    outcome.started = waitForExec(failure.read_end);
    std::optional<int> status;
    outcome.in_time = readUntil(out.read_end, deadline, settings.max_text_bytes, outcome.text) &&
                      hasEnded(child, deadline, status);
    if (!outcome.in_time) {
        kill(-child, SIGKILL);
        hasEnded(child, ChildClock::now() + settings.kill_timeout, status);
    }
    if (status && WIFEXITED(*status)) outcome.status = WEXITSTATUS(*status);
    if (status && WIFSIGNALED(*status)) outcome.signal = WTERMSIG(*status);
    return outcome;
}

}  // namespace stylet
