// Runs a short soak with every feature of this build, and checks that the soak detects each kind of leak.
#include "tests/bench/soak/soak.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>

#include "app/records/centre.h"
#include "patient/package/package.h"
#include "tests/support/postgres.h"
#include "tests/support/temp_folder.h"

namespace stylet::soak {
namespace {

struct Soaked {
    Result result;
    std::string complaints;
};

#ifdef STYLET_SOAK_PICTURES
constexpr bool kPictures = true;
#else
constexpr bool kPictures = false;
#endif

Soaked soaked(Leak leak, std::size_t scenarios, bool everything = false) {
    // Use memory instead of a disk: disk latency is not tested here. In a container /dev/shm may be small.
    std::error_code none;
    if (std::filesystem::space("/dev/shm", none).available > std::uintmax_t(1) << 30 && !none)
        setenv("TMPDIR", "/dev/shm", 0);
    const test::TempFolder folder;
    std::optional<test::Postgres> postgres;
    Settings settings;
    if (everything && records::hasCentre()) settings.centre = postgres.emplace().url();
    settings.pictures = everything && kPictures;
    settings.fps = 0.25;
    settings.ticks = 1;  // three rounds
    settings.spacing_m = 0.005;
    settings.folder = folder.path();
    settings.max_slowdown = 3.0;  // the machine may be busy with other work
    settings.leak = leak;
    if (leak == Leak::thread) settings.timeout = std::chrono::milliseconds(100);
    settings.scenarios = scenarios;
    Soaked s{soak(settings), ""};
    for (const std::string& line : findFailures(s.result, settings))
        s.complaints += line + "\n";
    return s;
}

// Returns true if there are complaints and all of them are about the tick time.
bool onlySlower(const Soaked& s) {
    std::istringstream lines(s.complaints);
    bool some = false, all = true;
    for (std::string line; std::getline(lines, line); some = true)
        all = all && line.find("quantile") != std::string::npos;
    return some && all;
}

// The soak also checks that repeated rounds end in the same hashes.
TEST(Soak, NoResourceGrowsWithAllFeatures) {
    if (records::hasCentre() && !test::Postgres::isInstalled()) GTEST_SKIP() << "no PostgreSQL";
    try {
        Soaked all = soaked(Leak::none, 3, true);
        // If the machine gets busy, ticks are slower for a while. With a leak they are slower in every run.
        for (int again = 0; again < 3 && onlySlower(all); ++again)
            all = soaked(Leak::none, 3, true);
        EXPECT_EQ(all.complaints, "") << formatReport(all.result);
        EXPECT_GT(all.result.counts.ticks, 300'000u);
    } catch (const DataError& e) {
        if (std::string(e.what()) != "--pictures: headset: there is none") throw;
        GTEST_SKIP() << e.what();
    }
}

class LeakySoak : public testing::TestWithParam<std::pair<Leak, const char*>> {};
INSTANTIATE_TEST_SUITE_P(
    Leaks, LeakySoak,
    testing::Values(std::pair(Leak::memory, "heap"), std::pair(Leak::descriptor, "descriptors"),
                    std::pair(Leak::thread, "threads"), std::pair(Leak::region, "regions"),
                    std::pair(Leak::time, "quantile"), std::pair(Leak::state, "another hash")));

TEST_P(LeakySoak, IsDetected) {
    const auto [leak, word] = GetParam();
    EXPECT_NE(soaked(leak, 1).complaints.find(word), std::string::npos) << word;
}

}  // namespace
}  // namespace stylet::soak
