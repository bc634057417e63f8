// Occupies all processors for 20 to 300 ms about once a second, until its standard input ends. Tests that run
// at the same time then stall as on an overloaded or virtual machine. `packaging/test --stutter N` starts it.
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <latch>
#include <random>
#include <thread>
#include <vector>

#include "tests/support/seed.h"

namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::milliseconds;

// Binds the calling thread to one processor at the highest real-time priority. Returns errno's value, 0 for
// success.
int occupy(unsigned processor) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(processor, &set);
    if (const int error = pthread_setaffinity_np(pthread_self(), sizeof set, &set)) return error;
    const sched_param priority{sched_get_priority_max(SCHED_FIFO)};
    return pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
}

// All threads use the same seed and the same start time, so all processors stall at the same time.
void stutter(std::uint64_t seed, Clock::time_point begin) {
    std::mt19937_64 random(seed);
    std::uniform_int_distribution<int> pause_ms(700, 1300), stall_ms(20, 300);
    for (Clock::time_point t = begin;;) {
        t += Milliseconds(pause_ms(random));
        std::this_thread::sleep_until(t);
        t += Milliseconds(stall_ms(random));
        while (Clock::now() < t) {
        }
    }
}

}  // namespace

int main() {
    const std::uint64_t seed = stylet::test::seed();
    const unsigned processors = std::thread::hardware_concurrency();
    std::latch occupied(processors);
    std::vector<std::thread> threads;
    const Clock::time_point begin = Clock::now() + Milliseconds(500);
    for (unsigned processor = 0; processor < processors; ++processor)
        threads.emplace_back([&, processor] {
            if (const int error = occupy(processor)) {
                std::fprintf(stderr, "stylet-stutter: real-time priority: %s. Run it as root.\n",
                             std::strerror(error));
                std::_Exit(3);
            }
            occupied.count_down();
            stutter(seed, begin);
        });
    occupied.wait();
    std::puts("stuttering");
    std::fflush(stdout);
    char ignored;
    while (read(STDIN_FILENO, &ignored, 1) > 0) {
    }
    std::_Exit(0);
}
