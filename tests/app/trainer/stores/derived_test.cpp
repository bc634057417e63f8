// Cached derived data is used only if the file is complete and belongs to the same inputs.
#include "app/trainer/stores/derived.h"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "app/trainer/stores/platform_linux.h"
#include "tests/app/trainer/phantom_attempt.h"
#include "tests/support/temp_folder.h"

namespace stylet::trainer {
namespace {

namespace fs = std::filesystem;

class Derived : public testing::Test {
  protected:
    void flip(std::size_t at) const {
        std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
        file.seekg(std::streamoff(at));
        const int byte = file.get();
        file.seekp(std::streamoff(at));
        file.put(char(byte ^ 0x20));
    }
    test::TempFolder folder_;
    const fs::path file_ = folder_ / "derived" / "numbers";
    const std::vector<std::byte> bytes_{std::byte{1}, std::byte{2}, std::byte{3}};
};

TEST_F(Derived, IsLoadedOnlyWithItsKey) {
    EXPECT_FALSE(loadDerived(file_, 7));
    saveDerived(file_, 7, bytes_);
    EXPECT_EQ(loadDerived(file_, 7), bytes_);
    EXPECT_FALSE(loadDerived(file_, 8));
    saveDerived(file_, 8, {});
    EXPECT_EQ(loadDerived(file_, 8), std::vector<std::byte>{});
    EXPECT_FALSE(loadDerived(file_, 7));
}

TEST_F(Derived, NoByteOfADamagedFileIsUsed) {
    saveDerived(file_, 7, bytes_);
    const std::size_t size = fs::file_size(file_);
    for (std::size_t at = 0; at < size; ++at) {
        flip(at);
        EXPECT_FALSE(loadDerived(file_, 7)) << "byte " << at;
        flip(at);
    }
    ASSERT_EQ(loadDerived(file_, 7), bytes_);
    for (std::size_t left = 0; left < size; ++left) {
        saveDerived(file_, 7, bytes_);
        fs::resize_file(file_, left);
        EXPECT_FALSE(loadDerived(file_, 7)) << left << " bytes";
    }
    saveDerived(file_, 7, bytes_);
    std::ofstream(file_, std::ios::app) << 'x';
    EXPECT_FALSE(loadDerived(file_, 7));
}

TEST_F(Derived, OldestFilesAreEvicted) {
    const auto named = [&](std::size_t i) { return file_.parent_path() / std::to_string(i); };
    const auto now = fs::file_time_type::clock::now();
    const std::size_t most = DerivedLimits().files;
    for (std::size_t i = 0; i < most; ++i) {
        saveDerived(named(i), i, bytes_);
        fs::last_write_time(named(i), now - std::chrono::hours(100 - int(i)));
    }
    EXPECT_EQ(loadDerived(named(0), 0), bytes_);  // used again, so no longer the oldest
    saveDerived(file_, 7, bytes_);
    EXPECT_TRUE(fs::exists(named(0)));
    EXPECT_FALSE(fs::exists(named(1)));
    EXPECT_TRUE(fs::exists(named(2)));
    EXPECT_TRUE(fs::exists(file_));
}

TEST_F(Derived, SizeLimitEvictsFiles) {
    const auto named = [&](std::size_t i) { return file_.parent_path() / std::to_string(i); };
    saveDerived(named(0), 0, bytes_);
    const std::uintmax_t one = fs::file_size(named(0));
    const auto now = fs::file_time_type::clock::now();
    for (std::size_t i = 0; i < 5; ++i) {
        saveDerived(named(i), i, bytes_, {.files = 100, .bytes = 3 * one});
        fs::last_write_time(named(i), now - std::chrono::hours(100 - int(i)));
        EXPECT_EQ(fs::exists(named(0)), i < 3);
    }
    for (std::size_t i = 0; i < 5; ++i)
        EXPECT_EQ(fs::exists(named(i)), i >= 2) << i;
    saveDerived(file_, 7, bytes_, {.files = 100, .bytes = 1});
    EXPECT_EQ(loadDerived(file_, 7), bytes_) << "the new one stays";
    EXPECT_FALSE(fs::exists(named(4)));
}

// A killed program leaves a partial file. A recent partial file may still be being written by another
// program.
TEST_F(Derived, UnfinishedFilesAreRemovedAtTheNextStart) {
    const auto left = [&](const std::string& name, int minutes) {
        const fs::path file = file_.parent_path() / name;
        std::ofstream(file) << "half";
        fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::minutes(minutes));
        return file;
    };
    saveDerived(file_, 7, bytes_);
    const fs::path old = left("numbers.123456", 90), young = left("numbers.654321", 10),
                   other = left("numbers.txt", 90);
    EXPECT_EQ(loadDerived(file_, 7), bytes_);
    EXPECT_FALSE(fs::exists(old));
    EXPECT_TRUE(fs::exists(young));
    EXPECT_TRUE(fs::exists(other));
}

TEST_F(Derived, UnwritableCacheIsNoError) {
    std::ofstream(folder_ / "derived") << "a file in the folder's place";
    saveDerived(file_, 7, bytes_);
    EXPECT_FALSE(loadDerived(file_, 7));
}

TEST_F(Derived, KeyDependsOnPartsAndOrder) {
    ASSERT_TRUE(derivedKey({1, 2})) << "the linker left no build id";
    EXPECT_EQ(derivedKey({1, 2}), derivedKey({1, 2}));
    EXPECT_NE(derivedKey({1, 2}), derivedKey({2, 1}));
    EXPECT_NE(derivedKey({1, 2}), derivedKey({1}));
}

TEST_F(Derived, ATouchMapIsTheSameEveryTime) {
    const patient::Package package = test::ductPhantom();
    const patient::Patient patient(package);
    const std::uint64_t digest = patient::digest(package);
    const haptics::TouchMap expected = haptics::makeTouchMap(patient);
    const auto same = [&](const haptics::TouchMap& map) {
        return map.grid == expected.grid && map.nodes == expected.nodes;
    };
    Made made;
    const auto kept = [&] { return loadOrMakeTouchMap(patient, digest, folder_ / "derived", &made); };
    EXPECT_TRUE(same(kept()));
    EXPECT_EQ(made.touch_maps, 1u);
    const auto only = [&] { return fs::directory_iterator(folder_ / "derived")->path(); };
    ASSERT_TRUE(fs::exists(only()));
    EXPECT_TRUE(same(kept()));
    EXPECT_EQ(made.touch_maps, 1u);

    const std::uintmax_t whole = fs::file_size(only());
    fs::resize_file(only(), whole / 2);
    EXPECT_TRUE(same(kept()));
    EXPECT_EQ(made.touch_maps, 2u);
    EXPECT_EQ(fs::file_size(only()), whole);
}

TEST(TouchMap, SurvivesSerialisation) {
    haptics::TouchMap map;
    map.grid.dims = {2, 3, 4};
    map.grid.spacing_m = {0.001, 0.002, 0.003};
    map.nodes.assign(3 * 2 * 3 * 4, 0.5F);
    const std::vector<std::byte> bytes = bytesOf(map);
    const auto again = parseTouchMap(bytes);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->nodes, map.nodes);
    EXPECT_TRUE(again->grid == map.grid);
    for (std::size_t left = 0; left < bytes.size(); ++left)
        EXPECT_FALSE(parseTouchMap(std::span(bytes).first(left))) << left;
    map.nodes[7] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(parseTouchMap(bytesOf(map)));
}

}  // namespace
}  // namespace stylet::trainer
