#include "app/study/result_blocks.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/app/study/pairs.h"
#include "tests/support/temp_folder.h"

namespace stylet::study {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPaths = 2 * kBlock + 10;

std::vector<PathResult> numbered(std::size_t begin, std::size_t count) {
    std::vector<PathResult> results(count);
    for (std::size_t i = 0; i < count; ++i)
        results[i].sampled.rmse_n = double(begin + i);
    return results;
}

void keepAll(const ResultBlocks& kept) {
    for (std::size_t b = kept.count(); b-- > 0;)
        kept.write(b, numbered(kept.begin(b), kept.size(b)));
}

TEST(ResultBlocks, ResultsAreReadInOrder) {
    const test::TempFolder temp;
    const ResultBlocks kept(temp / "blocks", 7, kPaths);
    ASSERT_EQ(kept.count(), 3u);
    EXPECT_EQ(kept.size(2), 10u);
    EXPECT_FALSE(kept.has(0));
    EXPECT_THROW(kept.all(), DataError);
    keepAll(kept);
    const std::vector<PathResult> all = kept.all();
    ASSERT_EQ(all.size(), kPaths);
    for (std::size_t i = 0; i < kPaths; ++i)
        ASSERT_EQ(all[i].sampled.rmse_n, double(i));
    EXPECT_TRUE(ResultBlocks(temp / "none", 7, 0).all().empty());
}

// HZ-RECORD-13
TEST(ResultBlocks, BlocksOfOtherRunsAreIgnored) {
    const test::TempFolder temp;
    keepAll(ResultBlocks(temp / "blocks", 7, kPaths));
    EXPECT_FALSE(ResultBlocks(temp / "blocks", 8, kPaths).has(0));      // another run
    EXPECT_FALSE(ResultBlocks(temp / "blocks", 7, kPaths + 1).has(2));  // another number of paths
    fs::copy_file(temp / "blocks/000000.results", temp / "blocks/000001.results",
                  fs::copy_options::overwrite_existing);
    EXPECT_FALSE(ResultBlocks(temp / "blocks", 7, kPaths).has(1));
}

// HZ-RECORD-13
TEST(ResultBlocks, DamagedBlocksAreDetected) {
    const test::TempFolder temp;
    const ResultBlocks kept(temp / "blocks", 7, kPaths);
    keepAll(kept);
    const fs::path file = temp / "blocks/000001.results";
    const auto whole = fs::file_size(file);
    for (const std::uintmax_t bytes : {std::uintmax_t(0), std::uintmax_t(20), whole - 1, whole + 1}) {
        fs::resize_file(file, bytes);
        EXPECT_FALSE(kept.has(1)) << bytes;
        EXPECT_THROW(kept.all(), DataError);
        kept.write(1, numbered(kBlock, kBlock));
        EXPECT_TRUE(kept.has(1));
    }
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(std::streamoff(whole / 2));
    stream.put('\x55');
    stream.close();
    EXPECT_FALSE(kept.has(1));
    std::ofstream(temp / "plain").put('x');
    EXPECT_ANY_THROW(ResultBlocks(temp / "plain", 7, kPaths).write(0, numbered(0, kBlock)));
}

TEST(ResultBlocks, DigestCoversAllInputsOfARun) {
    const Pair& pair = test::seededPair();
    const std::span paths(test::seededPaths());
    const std::uint64_t same = runDigest(pair, paths, {});
    EXPECT_EQ(runDigest(pair, paths, {}), same);
    RunSettings settings;
    settings.threads = 7;
    EXPECT_EQ(runDigest(pair, paths, settings), same);
    settings.steering.samples = 2000;
    EXPECT_NE(runDigest(pair, paths, settings), same);
    settings = {};
    settings.steering.breathing = true;
    EXPECT_NE(runDigest(pair, paths, settings), same);
    EXPECT_NE(runDigest(pair, paths.first(paths.size() - 1), {}), same);
    Pair other = pair;
    other.found.labels.voxels[1000] ^= 1;
    EXPECT_NE(runDigest(other, paths, {}), same);
    other = pair;
    other.labels = FoundLabels::all;
    EXPECT_NE(runDigest(other, paths, {}), same);
}

}  // namespace
}  // namespace stylet::study
