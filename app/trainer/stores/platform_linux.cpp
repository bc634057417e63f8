#include "app/trainer/stores/platform_linux.h"

#include <elf.h>
#include <link.h>
#include <poll.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "base/hash.h"
#include "patient/package/package.h"

namespace stylet::trainer {

namespace {

constexpr const char* kLimits = "/etc/security/limits.d/stylet.conf";            // packaging/debian/stylet
constexpr const char* kOwnLimits = "/etc/security/limits.d/90-own-stylet.conf";  // without the package
constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::atomic<int> was_interrupted{0};  // also read by threads that did not receive the signal
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may store it");

template <clockid_t kClock>
std::int64_t now(void*) noexcept {
    timespec t{};
    clock_gettime(kClock, &t);
    return t.tv_sec * kSecond_ns + t.tv_nsec;
}

void sleepUntil(void*, std::int64_t t_ns) noexcept {
    const timespec t{t_ns / kSecond_ns, t_ns % kSecond_ns};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
    }
}

std::uint64_t pageFaults(void*) noexcept {
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    return std::uint64_t(usage.ru_minflt) + std::uint64_t(usage.ru_majflt);
}

// Touches more stack than the loop's calls need. If memory cannot be locked, these pages are at least already
// mapped.
void touchStack() noexcept {
    constexpr std::size_t kStack = 256 * 1024, kPage = 4096;
    [[maybe_unused]] volatile unsigned char stack[kStack];
    for (std::size_t i = 0; i < kStack; i += kPage)
        stack[i] = 0;
}

}  // namespace

haptics::Clock monotonicClock() noexcept {
    return {nullptr, now<CLOCK_MONOTONIC>, sleepUntil, pageFaults};
}

haptics::Clock workClock() noexcept {
    return {nullptr, now<CLOCK_THREAD_CPUTIME_ID>, nullptr, nullptr};
}

std::string describeHowToAllow(const std::vector<std::string>& rights) {
    const std::string user = environment("USER");
    if (std::error_code none; std::filesystem::exists(kLimits, none))
        return "run \"sudo adduser " + (user.empty() ? "USER" : user) + " stylet\" (" + kLimits +
               " allows that group) and log in again";
    std::string lines;
    for (const std::string& right : rights)
        lines += (lines.empty() ? "\"" : " and \"") + (user.empty() ? "*" : user) + " - " + right + "\"";
    return "put " + lines + (rights.size() > 1 ? ", a line each," : "") + " into " + kOwnLimits +
           " and log in again";
}

std::string requestRealTime() {
    touchStack();
    std::string refused;
    std::vector<std::string> rights;
    sched_param parameter{};
    parameter.sched_priority = kRealTimePriority;
    if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter)) {
        refused = std::string("real-time priority (") + std::strerror(error) + ")";
        rights.push_back(kPriorityRight);
    }
    // Lock only the memory that is mapped now. The loop touches no other memory. Later allocations belong to
    // other threads and stay pageable.
    if (mlockall(MCL_CURRENT) != 0) {
        refused +=
            std::string(refused.empty() ? "" : " and ") + "locked memory (" + std::strerror(errno) + ")";
        rights.push_back(kMemoryRight);
    }
    if (refused.empty()) return {};
    return "no " + refused + ": the haptics loop may be late; " + describeHowToAllow(rights);
}

void catchInterrupts() noexcept {
    struct sigaction action{};
    action.sa_handler = [](int) { was_interrupted = 1; };
    action.sa_flags = int(SA_RESETHAND | SA_RESTART);
    // A device continues to output its last force if its program ends, and also if it is only stopped
    // (SIGTSTP).
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP})
        sigaction(signal, &action, nullptr);
    // A closed pipe, or a terminal that belongs to another process, must only make the call fail and not end
    // the program.
    for (const int signal : {SIGPIPE, SIGTTIN, SIGTTOU})
        std::signal(signal, SIG_IGN);
}

bool interrupted() noexcept {
    return was_interrupted != 0;
}

bool readTyped(std::string& text) {
    pollfd in{STDIN_FILENO, POLLIN, 0};
    if (poll(&in, 1, 0) <= 0) return true;
    // The kernel would stop a background job that reads from its terminal. -1: stdin is not that terminal.
    if (const pid_t foreground = tcgetpgrp(STDIN_FILENO); foreground >= 0 && foreground != getpgrp())
        return true;
    std::array<char, 4096> bytes{};
    const ssize_t count = read(STDIN_FILENO, bytes.data(), bytes.size());
    if (count <= 0) return false;
    text.append(bytes.data(), std::size_t(count));
    return true;
}

bool stderrIsTerminal() noexcept {
    return isatty(STDERR_FILENO) != 0;
}

std::string environment(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

void setEnvironment(const char* name, const std::string& value) {
    setenv(name, value.c_str(), 1);
}

namespace {

// Finds the build id in the first object, which is the program itself.
int findBuildId(dl_phdr_info* object, std::size_t, void* mark) noexcept {
    for (int i = 0; i < object->dlpi_phnum; ++i) {
        const ElfW(Phdr) & segment = object->dlpi_phdr[i];
        if (segment.p_type != PT_NOTE) continue;
        const auto* const notes = reinterpret_cast<const std::byte*>(object->dlpi_addr + segment.p_vaddr);
        const auto padded = [](std::size_t size) { return (size + 3) / 4 * 4; };
        for (std::size_t at = 0; at + sizeof(ElfW(Nhdr)) <= segment.p_memsz;) {
            ElfW(Nhdr) note;
            std::memcpy(&note, notes + at, sizeof note);
            const std::size_t name = at + sizeof note, id = name + padded(note.n_namesz);
            at = id + padded(note.n_descsz);
            if (at > segment.p_memsz) break;
            if (note.n_type != NT_GNU_BUILD_ID || note.n_namesz != 4 ||
                std::memcmp(notes + name, "GNU", 4) != 0)
                continue;
            StateHash hash;
            hash.addBytes({notes + id, note.n_descsz});
            *static_cast<std::uint64_t*>(mark) = hash.value();
            return 1;
        }
    }
    return 1;
}

}  // namespace

std::uint64_t buildId() noexcept {
    std::uint64_t mark = 0;
    dl_iterate_phdr(findBuildId, &mark);
    return mark;
}

std::uint64_t processId() noexcept {
    return std::uint64_t(getpid());
}

namespace {

// Returns the folder that the environment variable names, if its path is absolute.
std::optional<std::filesystem::path> absoluteFolder(const char* variable) {
    std::filesystem::path folder = environment(variable);
    if (!folder.is_absolute()) return std::nullopt;
    return folder;
}

// Returns the folder from the environment variable, else the folder in the home directory, else a temporary
// folder that is lost at the next boot.
std::filesystem::path userFolder(const char* variable, const char* in_home) {
    if (const auto folder = absoluteFolder(variable)) return *folder / "stylet";
    if (const auto home = absoluteFolder("HOME")) return *home / in_home / "stylet";
    return std::filesystem::temp_directory_path() / "stylet";
}

}  // namespace

std::filesystem::path cacheFolder() {
    return userFolder("XDG_CACHE_HOME", ".cache");
}

std::filesystem::path dataFolder() {
    return userFolder("XDG_DATA_HOME", ".local/share");
}

bool isDataTemporary() {
    return !absoluteFolder("XDG_DATA_HOME") && !absoluteFolder("HOME");
}

}  // namespace stylet::trainer
