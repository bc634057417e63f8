#include "base/memory_linux.h"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace stylet {

void keepFreedMemory() {
    // About what a build of a patient needs at 1 mm. Memory beyond it is kept too, in ordinary pages.
    constexpr std::size_t kVolumes_bytes = std::size_t{3} << 29;
    // One arena: what one thread has freed, another can use.
    if (mallopt(M_ARENA_MAX, 1) == 0 || mallopt(M_MMAP_MAX, 0) == 0 || mallopt(M_TRIM_THRESHOLD, -1) == 0)
        return;
    void* const volumes = std::malloc(kVolumes_bytes);
    if (!volumes) return;
    const auto page = std::uintptr_t(sysconf(_SC_PAGESIZE));
    const std::uintptr_t begin = (std::uintptr_t(volumes) + page - 1) / page * page;
    madvise(reinterpret_cast<void*>(begin), kVolumes_bytes - page, MADV_HUGEPAGE);
    std::free(volumes);
}

}  // namespace stylet
