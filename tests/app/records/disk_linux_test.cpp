// This program replaces fsync and fdatasync of the C library with its own versions, which count the calls.
#include "app/records/disk_linux.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <fstream>

#include "app/records/record.h"
#include "tests/app/records/privacy.h"
#include "tests/support/temp_folder.h"

namespace {

int folder_syncs = 0, file_syncs = 0;

}  // namespace

extern "C" int fsync(int descriptor) {
    ++folder_syncs;
    return int(syscall(SYS_fsync, descriptor));
}

extern "C" int fdatasync(int descriptor) {
    ++file_syncs;
    return int(syscall(SYS_fdatasync, descriptor));
}

namespace stylet::records {
namespace {

// HZ-RECORD-01
TEST(Disk, RecordIsSyncedAtBeginEverySecondAndAtEnd) {
    const test::TempFolder temp;
    folder_syncs = file_syncs = 0;
    RecordWriter writer(temp / "record", {}, {});
    EXPECT_EQ(file_syncs, 2) << "inputs.bin, record.json";
    EXPECT_EQ(folder_syncs, 3) << "emptied, its name in the folder above, record.json renamed";
    for (std::uint32_t i = 0; i < 3 * kSyncTicks + 100; ++i)
        writer.add({}, i + 1, 0);
    EXPECT_EQ(file_syncs, 5);
    writer.finish();
    EXPECT_EQ(file_syncs, 7);
    EXPECT_EQ(folder_syncs, 4);
}

TEST(Disk, ExistingFileIsTruncatedAndWritten) {
    const test::TempFolder temp;
    const unsigned char bytes[] = {1, 2, 3};
    DiskFile(temp / "file").write(bytes);
    EXPECT_EQ(std::filesystem::file_size(temp / "file"), 3u);
    const DiskFile again(temp / "file");
    EXPECT_EQ(std::filesystem::file_size(temp / "file"), 0u);
}

TEST(Disk, UnopenableFilesAreRefused) {
    EXPECT_THROW(DiskFile("/nonexistent/file"), DataError);
    EXPECT_THROW(syncFolder("/nonexistent"), DataError);
}

// HZ-RECORD-10
TEST(Disk, NewFilesAndFoldersArePrivateWhateverTheUmask) {
    const test::TempFolder temp;
    const test::PermissiveUmask permissive;
    createPrivateFolders(temp / "a" / "b");
    createPrivateFolders(temp / "a" / "b");
    createPrivateFile(temp / "a" / "empty");
    DiskFile(temp / "a" / "b" / "file").write({});
    EXPECT_TRUE(FileLock::tryLock(temp / "a" / ".lock"));
    EXPECT_EQ(test::openEntries(temp / "a"), "");
    // Files that were there before become private; what they contain stays.
    std::ofstream(temp / "old") << "text";
    EXPECT_EQ(test::openEntries(temp / "old"), "old 666; ");
    createPrivateFile(temp / "old");
    EXPECT_EQ(std::filesystem::file_size(temp / "old"), 4u);
    DiskFile(temp / "old").write({});
    EXPECT_EQ(test::openEntries(temp / "old"), "");
    EXPECT_THROW(createPrivateFolders("/proc/nothing/here"), DataError);
    EXPECT_THROW(createPrivateFile("/nonexistent/file"), DataError);
}

// HZ-RECORD-10
TEST(Disk, TreeIsMadePrivateWithoutFollowingLinks) {
    const test::TempFolder temp;
    const test::PermissiveUmask permissive;
    std::filesystem::create_directories(temp / "tree" / "deep");
    std::ofstream(temp / "tree" / "deep" / "file") << "x";
    std::ofstream(temp / "outside") << "x";
    std::filesystem::create_directories(temp / "other");
    std::filesystem::create_symlink(temp / "outside", temp / "tree" / "link");
    std::filesystem::create_directory_symlink(temp / "other", temp / "tree" / "folder");
    std::filesystem::create_symlink(temp / "nothing", temp / "tree" / "dangling");
    EXPECT_EQ(makeTreePrivate(temp / "tree"), 3u);
    EXPECT_EQ(makeTreePrivate(temp / "tree"), 0u) << "nothing is left to do";
    EXPECT_EQ(test::openEntries(temp / "tree"), "");
    EXPECT_EQ(test::openEntries(temp / "outside"), "outside 666; ");
    EXPECT_EQ(test::openEntries(temp / "other"), "other 777; ");
    EXPECT_EQ(makeTreePrivate(temp / "gone"), 0u) << "another process may have removed it";
}

}  // namespace
}  // namespace stylet::records
