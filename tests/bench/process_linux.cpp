// What the running process holds, as the system and the allocator tell it.
#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tests/bench/soak.h"

namespace stylet::soak {

namespace {

int entriesOf(const char* folder) {
    int count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder))
        ++count;
    return count;
}

}  // namespace

Held heldNow() {
    Held held;
    malloc_trim(0);  // what was freed is not held
    const struct mallinfo2 heap = mallinfo2();
    held.heap_bytes = heap.uordblks + heap.hblkhd;
    std::ifstream file("/proc/self/statm");
    std::uint64_t all = 0, resident = 0;
    file >> all >> resident;
    held.resident_bytes = resident * std::uint64_t(sysconf(_SC_PAGESIZE));
    held.descriptors = entriesOf("/proc/self/fd");
    held.threads = entriesOf("/proc/self/task");
    return held;
}

int openNothing() {
    return open("/dev/null", O_RDONLY | O_CLOEXEC);
}

}  // namespace stylet::soak
