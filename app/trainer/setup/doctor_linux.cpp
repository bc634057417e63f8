#include "app/trainer/setup/doctor_linux.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <thread>

#include "app/trainer/stores/platform_linux.h"
#include "base/whole_file.h"

extern char** environ;

namespace stylet::trainer {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr std::size_t kMostText = 1u << 20;
constexpr auto kDeathWithin = std::chrono::milliseconds(500);

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
    void closeWriting() {
        if (write_end >= 0) close(write_end);
        write_end = -1;
    }
};

pid_t start(const std::filesystem::path& program, const std::vector<std::string>& arguments,
            const Pipe& out) {
    std::vector<char*> words{const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments)
        words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&files, out.write_end, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    sigset_t as_usual;  // signals with default action: we ignore SIGPIPE, a child must not
    sigemptyset(&as_usual);
    sigaddset(&as_usual, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &as_usual);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes, 0);
    pid_t child = -1;
    if (posix_spawn(&child, program.c_str(), &files, &attributes, words.data(), environ) != 0) child = -1;
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return child;
}

// Reads until the other end closes or the deadline passes.
std::string readUntil(int from, SteadyClock::time_point deadline, bool& closed) {
    std::string text;
    closed = false;
    while (!closed && text.size() < kMostText) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - SteadyClock::now());
        if (left.count() <= 0) break;
        pollfd wait{from, POLLIN, 0};
        if (poll(&wait, 1, int(left.count())) <= 0) continue;
        std::array<char, 4096> bytes{};
        const ssize_t count = read(from, bytes.data(), bytes.size());
        closed = count == 0 || (count < 0 && errno != EINTR);
        if (count > 0) text.append(bytes.data(), std::size_t(count));
    }
    return text;
}

// Waits for the child until the deadline: a process stuck in the kernel would block the wait forever.
std::optional<int> endOf(pid_t child, SteadyClock::time_point deadline) {
    for (int status = 0;; std::this_thread::sleep_for(std::chrono::milliseconds(5))) {
        if (waitpid(child, &status, WNOHANG) == child) return status;
        if (SteadyClock::now() > deadline) return std::nullopt;
    }
}

}  // namespace

ChildOutcome runChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                      std::chrono::milliseconds patience) {
    ChildOutcome outcome;
    const auto deadline = SteadyClock::now() + patience;
    Pipe out;
    const pid_t child = out.write_end < 0 ? -1 : start(program, arguments, out);
    out.closeWriting();
    if (child < 0) return outcome;
    outcome.started = true;
    bool closed = false;
    const std::string text = readUntil(out.read_end, deadline, closed);
    std::optional<int> end = closed ? endOf(child, deadline) : std::nullopt;
    outcome.in_time = end.has_value();
    if (!end) {
        kill(-child, SIGKILL);
        end = endOf(child, SteadyClock::now() + kDeathWithin);
    }
    if (end && WIFEXITED(*end)) outcome.status = WEXITSTATUS(*end);
    if (end && WIFSIGNALED(*end)) outcome.signal = WTERMSIG(*end);
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t line_end = text.find('\n', begin);
        if (line_end == std::string::npos) break;
        outcome.lines.push_back(text.substr(begin, line_end - begin));
        begin = line_end + 1;
    }
    return outcome;
}

std::filesystem::path thisProgram() {
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error);
}

RealTimeLimits realTimeLimits() {
    RealTimeLimits limits;
    std::thread([&] {
        sched_param parameter{};
        parameter.sched_priority = kRealTimePriority;
        if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter))
            limits.priority_refused = std::strerror(error);
    }).join();
    if (mlockall(MCL_CURRENT) != 0)
        limits.memory_refused = std::strerror(errno);
    else
        munlockall();
    return limits;
}

FolderState folderState(const std::filesystem::path& folder) {
    FolderState state;
    try {
        needFolder(folder, "folder");
        state.free_bytes = std::filesystem::space(folder).available;
        const std::filesystem::path file = folder / (".doctor-" + std::to_string(getpid()));
        writeWholeFile(file, "x");
        std::error_code gone;
        std::filesystem::remove(file, gone);
    } catch (const std::exception& e) {
        state.refused = e.what();
    }
    return state;
}

std::string firstLine(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::string line;
    std::getline(stream, line);
    return line;
}

}  // namespace stylet::trainer
