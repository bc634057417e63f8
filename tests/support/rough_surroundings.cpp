// A library that is preloaded into a program (LD_PRELOAD) to disturb it. The wall clock jumps back and forth
// by days, the locale of the environment is active (as if a library had set it), and a signal arrives at a
// chosen point.
//   STYLET_TEST_CLOCK=1, STYLET_TEST_LOCALE=1
//   STYLET_TEST_SIGNAL=15 with one of
//     STYLET_TEST_AT="open NAME"    just before a file of this name is opened for writing
//     STYLET_TEST_AT="rename NAME"  just before a written file is renamed to this name
//     STYLET_TEST_AT="word 3"       after the third flush of stderr
#include <dlfcn.h>
#include <signal.h>
#include <sys/time.h>
#include <time.h>

#include <atomic>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <locale>
#include <string>
#include <string_view>

namespace {

std::atomic<unsigned> clock_reads{0}, flushes{0};

long clockJump_s() {
    constexpr long kDay_s = 86400;
    constexpr long kLeaps_s[] = {0, 40 * kDay_s, -3000 * kDay_s, 17, -1};
    static const bool on = std::getenv("STYLET_TEST_CLOCK") != nullptr;
    return on ? kLeaps_s[clock_reads.fetch_add(1) % 5] : 0;
}

void raiseSignalAt(const std::string& point) {
    static const char* const at = std::getenv("STYLET_TEST_AT");
    static const char* const number = std::getenv("STYLET_TEST_SIGNAL");
    if (at && number && point == at) raise(std::atoi(number));
}

std::string nameOf(const char* path) {
    const std::string_view whole = path;
    return std::string(whole.substr(whole.rfind('/') + 1));  // npos + 1 is 0
}

template <typename F>
F next(const char* name) {
    return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

using Open = FILE* (*)(const char*, const char*);
FILE* opened(Open real, const char* path, const char* mode) {
    if (*mode != 'r') raiseSignalAt("open " + nameOf(path));
    return real(path, mode);
}

const struct Locale {
    Locale() {
        if (!std::getenv("STYLET_TEST_LOCALE")) return;
        std::setlocale(LC_ALL, "");
        std::locale::global(std::locale(""));
    }
} locale;

}  // namespace

extern "C" {
int clock_gettime(clockid_t clock, timespec* t) noexcept {
    static const auto real = next<int (*)(clockid_t, timespec*)>("clock_gettime");
    const int result = real(clock, t);
    if (result == 0 && clock == CLOCK_REALTIME) t->tv_sec += clockJump_s();
    return result;
}
int gettimeofday(timeval* t, void* zone) noexcept {
    static const auto real = next<int (*)(timeval*, void*)>("gettimeofday");
    const int result = real(t, zone);
    if (result == 0) t->tv_sec += clockJump_s();
    return result;
}
time_t time(time_t* t) noexcept {
    static const auto real = next<time_t (*)(time_t*)>("time");
    const time_t now = real(nullptr) + clockJump_s();
    if (t) *t = now;
    return now;
}
FILE* fopen(const char* path, const char* mode) {
    static const auto real = next<Open>("fopen");
    return opened(real, path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
    static const auto real = next<Open>("fopen64");
    return opened(real, path, mode);
}
int rename(const char* from, const char* to) noexcept {
    static const auto real = next<int (*)(const char*, const char*)>("rename");
    raiseSignalAt("rename " + nameOf(to));
    return real(from, to);
}
int fflush(FILE* stream) {
    static const auto real = next<int (*)(FILE*)>("fflush");
    const int result = real(stream);
    if (stream == stderr) raiseSignalAt("word " + std::to_string(flushes.fetch_add(1) + 1));
    return result;
}
}
