#include "base/cache_file.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <string>
#include <string_view>

#include "patient/package/package.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> bytesOf(std::string_view text) {
    return std::as_bytes(std::span(text));
}
std::string restOf(std::istream& in) {
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(CacheFile, ReplacesTheOldOneWhichItsReadersKeep) {
    const test::TempFolder folder;
    const fs::path file = folder / "a" / "b" / "file";
    writeCacheFile(file, {bytesOf("the "), bytesOf("old one")});
    std::ifstream reader(file);
    writeCacheFile(file, {bytesOf("new")});
    EXPECT_EQ(restOf(reader), "the old one");
    std::ifstream later(file);
    EXPECT_EQ(restOf(later), "new");
    EXPECT_EQ(std::distance(fs::directory_iterator(file.parent_path()), fs::directory_iterator()), 1);
}

TEST(CacheFile, WhatCannotBeWrittenIsSaidAndLeavesNothing) {
    const test::TempFolder folder;
    fs::create_directories(folder / "taken" / "inside");
    try {
        writeCacheFile(folder / "taken", {bytesOf("new")});
        FAIL() << "no exception";
    } catch (const DataError& e) {
        EXPECT_NE(std::string(e.what()).find("taken: file: cannot be written: "), std::string::npos)
            << e.what();
    }
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
    std::ofstream(folder / "file") << "no folder";
    EXPECT_THROW(writeCacheFile(folder / "file" / "new", {bytesOf("new")}), DataError);
}

TEST(CacheFile, LeftoversOfTheNameGoWhenTheyAreOld) {
    const test::TempFolder folder;
    const auto made = [&](const std::string& name, int minutes) {
        std::ofstream(folder / name) << "half";
        fs::last_write_time(folder / name, fs::file_time_type::clock::now() - std::chrono::minutes(minutes));
    };
    const auto is = [&](const std::string& name) { return fs::exists(folder / name); };
    for (const char* name : {"cache", "cache.1", "cache.x1", "cache.", "cache.2.3", "other.4", "5"})
        made(name, 61);
    made("cache.6", 59);
    sweepLeftovers(folder.path(), "cache");
    EXPECT_FALSE(is("cache.1"));
    for (const char* name : {"cache", "cache.x1", "cache.", "cache.2.3", "other.4", "5", "cache.6"})
        EXPECT_TRUE(is(name)) << name;
    sweepLeftovers(folder.path());
    EXPECT_FALSE(is("other.4"));
    for (const char* name : {"cache", "cache.x1", "cache.", "5", "cache.6"})
        EXPECT_TRUE(is(name)) << name;
    sweepLeftovers(folder / "none");
}

}  // namespace
}  // namespace stylet::patient
