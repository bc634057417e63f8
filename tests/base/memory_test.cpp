#include "base/memory_linux.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <memory>
#include <vector>

#ifndef STYLET_SANITIZED  // a sanitizer's allocator has its own rules for freed memory

namespace stylet {
namespace {

long pageFaults() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_minflt;
}

// Makes, fills and frees volumes of 40 MB, one after the other. Returns the page faults of the later ones.
long pageFaultsOfLaterVolumes() {
    constexpr std::size_t kVoxels = 10'000'000;
    long first = 0;
    for (int volume = 0; volume < 5; ++volume) {
        const std::vector<float> voxels(kVoxels, float(volume));
        if (voxels[kVoxels / 2] != float(volume)) std::abort();
        if (volume == 0) first = pageFaults();
    }
    return pageFaults() - first;
}

[[noreturn]] void exitWithTrue(bool value) {
    std::_Exit(value ? 0 : 1);
}

// In child processes, because the setting cannot be taken back. Four volumes have at least 80 pages, if the
// pages are huge.
TEST(Memory, LaterVolumesReuseThePagesOfEarlierOnes) {
    EXPECT_EXIT(exitWithTrue(pageFaultsOfLaterVolumes() > 60), testing::ExitedWithCode(0), "")
        << "without the setting, later volumes cost no page faults: is it still needed?";
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
