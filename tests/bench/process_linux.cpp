// Resources of the running process, as reported by the system and the allocator.
#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "tests/bench/soak/soak.h"

namespace stylet::soak {

namespace {

int entriesOf(const char* folder) {
    int count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder))
        ++count;
    return count;
}

}  // namespace

void steadyHeap() {
    mallopt(M_ARENA_MAX, 2);
}

Held heldNow(int threads, std::chrono::milliseconds patience) {
    const auto end = std::chrono::steady_clock::now() + patience;
    while (threads > 0 && entriesOf("/proc/self/task") > threads && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    Held held;
    malloc_trim(0);  // return freed memory, so that it does not count as resident
    const struct mallinfo2 heap = mallinfo2();
    held.heap_bytes = heap.uordblks + heap.hblkhd;
    std::ifstream file("/proc/self/statm");
    std::uint64_t all = 0, resident = 0;
    file >> all >> resident;
    held.resident_bytes = resident * std::uint64_t(sysconf(_SC_PAGESIZE));
    held.descriptors = entriesOf("/proc/self/fd");
    held.threads = entriesOf("/proc/self/task");
    std::ifstream maps("/proc/self/maps");
    held.regions = int(std::count(std::istreambuf_iterator<char>(maps), {}, '\n'));
    struct stat log{};
    if (fstat(STDERR_FILENO, &log) == 0 && S_ISREG(log.st_mode))
        held.logged_bytes = std::uint64_t(log.st_size);
    return held;
}

double threadTime_us() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e6 * double(now.tv_sec) + 1e-3 * double(now.tv_nsec);
}

void mapNothing() {
    // Alternate the rights: the kernel merges adjacent mappings with the same rights into one region.
    for (int i = 0; i < 20; ++i)
        for (const int rights : {PROT_READ, PROT_NONE})
            mmap(nullptr, std::size_t(sysconf(_SC_PAGESIZE)), rights, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
}

int openNothing() {
    return open("/dev/null", O_RDONLY | O_CLOEXEC);
}

}  // namespace stylet::soak
