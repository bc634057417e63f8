#include "base/cache_file.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <string>
#include <string_view>

#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> bytesOf(std::string_view text) {
    return std::as_bytes(std::span(text));
}
std::string readRemainder(std::istream& in) {
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(CacheFile, OpenReadersStillSeeTheReplacedFile) {
    const test::TempFolder folder;
    const fs::path file = folder / "a" / "b" / "file";
    writeCacheFile(file, {bytesOf("the "), bytesOf("old one")});
    std::ifstream reader(file);
    writeCacheFile(file, {bytesOf("new")});
    EXPECT_EQ(readRemainder(reader), "the old one");
    std::ifstream later(file);
    EXPECT_EQ(readRemainder(later), "new");
    EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), fs::directory_iterator()), 1);
}

TEST(CacheFile, FailedWriteReportsTheReasonAndLeavesNoFile) {
    const test::TempFolder folder;
    fs::create_directories(folder / "taken" / "inside");
    test::expectRefused([&] { writeCacheFile(folder / "taken", {bytesOf("new")}); }, "taken",
                        "file: cannot be written: ");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
    std::ofstream(folder / "file") << "no folder";
    EXPECT_THROW(writeCacheFile(folder / "file" / "new", {bytesOf("new")}), DataError);
}

TEST(CacheFile, OldTemporaryFilesOfTheNameAreRemoved) {
    const test::TempFolder folder;
    const auto createFile = [&](const std::string& name, int minutes) {
        std::ofstream(folder / name) << "half";
        fs::last_write_time(folder / name, fs::file_time_type::clock::now() - std::chrono::minutes(minutes));
    };
    const auto fileExists = [&](const std::string& name) { return fs::exists(folder / name); };
    for (const char* name : {"cache", "cache.1", "cache.x1", "cache.", "cache.2.3", "other.4", "5"})
        createFile(name, 61);
    createFile("cache.6", 59);
    removeStaleTemporaryFiles(folder.path(), "cache");
    EXPECT_FALSE(fileExists("cache.1"));
    for (const char* name : {"cache", "cache.x1", "cache.", "cache.2.3", "other.4", "5", "cache.6"})
        EXPECT_TRUE(fileExists(name)) << name;
    removeStaleTemporaryFiles(folder.path());
    EXPECT_FALSE(fileExists("other.4"));
    for (const char* name : {"cache", "cache.x1", "cache.", "5", "cache.6"})
        EXPECT_TRUE(fileExists(name)) << name;
    removeStaleTemporaryFiles(folder / "none");
}

}  // namespace
}  // namespace stylet::patient
