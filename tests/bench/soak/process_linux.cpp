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

int countEntries(const char* folder) {
    int count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder))
        ++count;
    return count;
}

}  // namespace

void limitHeapArenas() {
    mallopt(M_ARENA_MAX, 2);
}

ResourceUse measureResources(int threads, std::chrono::milliseconds timeout) {
    const auto end = std::chrono::steady_clock::now() + timeout;
    while (threads > 0 && countEntries("/proc/self/task") > threads && std::chrono::steady_clock::now() < end)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ResourceUse resources;
    malloc_trim(0);  // return freed memory, so that it does not count as resident
    const struct mallinfo2 heap = mallinfo2();
    resources.heap_bytes = heap.uordblks + heap.hblkhd;
    std::ifstream file("/proc/self/statm");
    std::uint64_t all = 0, resident = 0;
    file >> all >> resident;
    resources.resident_bytes = resident * std::uint64_t(sysconf(_SC_PAGESIZE));
    resources.descriptors = countEntries("/proc/self/fd");
    resources.threads = countEntries("/proc/self/task");
    std::ifstream maps("/proc/self/maps");
    resources.regions = int(std::count(std::istreambuf_iterator<char>(maps), {}, '\n'));
    struct stat log{};
    if (fstat(STDERR_FILENO, &log) == 0 && S_ISREG(log.st_mode))
        resources.logged_bytes = std::uint64_t(log.st_size);
    return resources;
}

double threadTime_us() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e6 * double(now.tv_sec) + 1e-3 * double(now.tv_nsec);
}

void leakRegions() {
    // Alternate the rights: the kernel merges adjacent mappings with the same rights into one region.
    for (int i = 0; i < 20; ++i)
        for (const int rights : {PROT_READ, PROT_NONE})
            mmap(nullptr, std::size_t(sysconf(_SC_PAGESIZE)), rights, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
}

int leakDescriptor() {
    return open("/dev/null", O_RDONLY | O_CLOEXEC);
}

}  // namespace stylet::soak
