#include "base/memory_linux.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <thread>
#include <vector>

#ifndef STYLET_SANITIZED  // a sanitizer's allocator has its own rules for freed memory

namespace stylet {
namespace {

long pageFaults() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_minflt;
}

void useVolume() {
    constexpr std::size_t kVoxels = 10'000'000;
    const std::vector<float> voxels(kVoxels, 1.0f);
    if (voxels[kVoxels / 2] != 1.0f) std::abort();
}

// A thread makes, fills and frees a volume of 40 MB. Then this thread does so four times. Returns its page
// faults.
long pageFaultsOfLaterVolumes() {
    std::thread(useVolume).join();
    const long before = pageFaults();
    for (int volume = 0; volume < 4; ++volume)
        useVolume();
    return pageFaults() - before;
}

[[noreturn]] void exitWithTrue(bool value) {
    std::_Exit(value ? 0 : 1);
}

// In child processes, because the setting cannot be taken back. Without it, each volume costs at least 20
// page faults, even with huge pages. With it, later volumes cost none; a few may come from other code.
TEST(MemoryDeathTest, LaterVolumesReuseThePagesOfEarlierOnes) {
    EXPECT_EXIT(exitWithTrue(pageFaultsOfLaterVolumes() > 60), testing::ExitedWithCode(0), "");
    EXPECT_EXIT(
        {
            keepFreedMemory();
            exitWithTrue(pageFaultsOfLaterVolumes() < 20);
        },
        testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace stylet

#endif
