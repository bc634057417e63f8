// This program replaces fsync and fdatasync of the C library with its own versions, which count the calls.
#include "app/records/disk_linux.h"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "app/records/record.h"
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

}  // namespace
}  // namespace stylet::records
