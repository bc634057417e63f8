// The soak in short, twice; and that it finds what it is there to find.
#include "tests/bench/soak.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/support/temp_folder.h"

namespace stylet::soak {
namespace {

struct Soaked {
    Result result;
    std::string complaints;
};

Soaked soaked(Leak leak, std::size_t scenarios) {
    // What waits for a disk tells nothing here.
    setenv("TMPDIR", "/dev/shm", 0);
    const test::TempFolder folder;
    Settings settings;
    settings.ticks = 1;  // three rounds
    settings.spacing_m = 0.005;
    settings.folder = folder.path();
    settings.most_slower = 3.0;  // on a machine that does something else besides
    settings.leak = leak;
    settings.scenarios = scenarios;
    Soaked s{soak(settings), ""};
    for (const std::string& line : complaintsOf(s.result, settings))
        s.complaints += line + "\n";
    return s;
}

TEST(Soak, NothingGrowsAndTheSameSeedEndsInTheSameState) {
    const Soaked first = soaked(Leak::none, 3);
    EXPECT_EQ(first.complaints, "") << reportOf(first.result);
    EXPECT_GT(first.result.counts.ticks, 300'000u);
    EXPECT_EQ(soaked(Leak::none, 3).result.state_hash, first.result.state_hash);
}

class LeakySoak : public testing::TestWithParam<std::pair<Leak, const char*>> {};
INSTANTIATE_TEST_SUITE_P(Leaks, LeakySoak,
                         testing::Values(std::pair(Leak::memory, "heap"),
                                         std::pair(Leak::descriptor, "descriptors"),
                                         std::pair(Leak::thread, "threads"),
                                         std::pair(Leak::time, "quantile"),
                                         std::pair(Leak::state, "another hash")));

TEST_P(LeakySoak, Fails) {
    const auto [leak, word] = GetParam();
    EXPECT_NE(soaked(leak, 1).complaints.find(word), std::string::npos) << word;
}

}  // namespace
}  // namespace stylet::soak
