// Put before a program (LD_PRELOAD), makes its surroundings rough: a wall clock that leaps back and forth by
// days, and a locale of the user's that a library has switched on.
#include <dlfcn.h>
#include <sys/time.h>
#include <time.h>

#include <atomic>
#include <clocale>
#include <cstdlib>
#include <locale>

namespace {

std::atomic<unsigned> asked{0};

long leap() {
    constexpr long kDay_s = 86400;
    constexpr long kLeaps_s[] = {0, 40 * kDay_s, -3000 * kDay_s, 17, -1};
    static const bool on = std::getenv("STYLET_TEST_CLOCK") != nullptr;
    return on ? kLeaps_s[asked.fetch_add(1) % 5] : 0;
}

template <typename F>
F next(const char* name) {
    return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
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
    if (result == 0 && clock == CLOCK_REALTIME) t->tv_sec += leap();
    return result;
}
int gettimeofday(timeval* t, void* zone) noexcept {
    static const auto real = next<int (*)(timeval*, void*)>("gettimeofday");
    const int result = real(t, zone);
    if (result == 0) t->tv_sec += leap();
    return result;
}
time_t time(time_t* t) noexcept {
    static const auto real = next<time_t (*)(time_t*)>("time");
    const time_t now = real(nullptr) + leap();
    if (t) *t = now;
    return now;
}
}
