#include "base/whole_file.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <fstream>

#include "tests/support/file_text.h"
#include "tests/support/refused.h"
#include "tests/support/temp_folder.h"

namespace stylet::patient {
namespace {

namespace fs = std::filesystem;
using test::readText;

std::string writeErrorText(const fs::path& file, std::string_view bytes) {
    return test::errorText([&] { writeWholeFile(file, bytes); });
}

TEST(WholeFile, ReplacesTheFileAndLeavesNoTemporary) {
    const test::TempFolder folder;
    writeWholeFile(folder / "a", "longer than the next");
    writeWholeFile(folder / "a", std::string_view("n\0w\n", 4));
    EXPECT_EQ(readText(folder / "a"), std::string("n\0w\n", 4));
    writeWholeFile(folder / "a", "");
    EXPECT_EQ(fs::file_size(folder / "a"), 0u);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(WholeFile, FailedWritesReportTheReason) {
    const test::TempFolder folder;
    const fs::path nowhere = folder / "none" / "a";
    EXPECT_EQ(writeErrorText(nowhere, "x"),
              nowhere.string() + ": file: cannot be written: No such file or directory");
    EXPECT_EQ(writeErrorText("/dev/full", "x"),
              "/dev/full: file: cannot be written: No space left on device");
    EXPECT_EQ(writeErrorText(folder.path(), "x"),
              folder.path().string() + ": file: cannot be written: Is a directory");
}

TEST(WholeFile, FullDiskLeavesTheOldFile) {
    const test::TempFolder folder;
    writeWholeFile(folder / "a", "old");
    const auto before = signal(SIGXFSZ, SIG_IGN);
    rlimit usual{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &usual), 0);
    rlimit small = usual;
    small.rlim_cur = 5000;
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    const std::string why = writeErrorText(folder / "a", std::string(100'000, 'x'));
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &usual), 0);
    signal(SIGXFSZ, before);
    EXPECT_EQ(why, (folder / "a").string() + ": file: cannot be written: File too large");
    EXPECT_EQ(readText(folder / "a"), "old");
    EXPECT_FALSE(fs::exists(folder / "a.new"));
}

// Writing goes through a link, so a reader of a pipe or of the link's target gets the new content.
TEST(WholeFile, WritesThroughASymbolicLink) {
    const test::TempFolder folder;
    std::ofstream(folder / "real") << "old";
    fs::create_symlink(folder / "real", folder / "link");
    writeWholeFile(folder / "link", "new");
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_EQ(readText(folder / "real"), "new");
}

}  // namespace
}  // namespace stylet::patient
