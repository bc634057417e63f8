// Files and folders that only their owner can read, and whose contents survive a power loss because they are
// written through to the disk. All operating-system calls for records are here and in socket_linux.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

namespace stylet::records {

// Attempts are personal data: files get mode 0600 and folders 0700, whatever the process's umask allows.

// From now on, files and folders that any part of this process creates are private. Call it before there are
// threads.
void makeNewFilesPrivate();
// Creates the folder and its missing parents, private. An existing folder stays as it is.
void createPrivateFolders(const std::filesystem::path& folder);
// Creates an empty private file if there is none. Never opens an existing one: closing it would release the
// locks that SQLite has on it.
void createPrivateFile(const std::filesystem::path& file);
// Withdraws the access of group and others from this file or folder alone. Returns true if there was any.
// Leaves a missing entry and a symbolic link alone.
bool makePrivate(const std::filesystem::path&);
// Withdraws the access of group and others from the folder and everything in it, and returns the number of
// entries changed. Does not follow symbolic links.
std::size_t makeTreePrivate(const std::filesystem::path& folder);

// A new private file; an existing one is truncated and made private. Written bytes are in the file at once,
// and on the disk after sync(). Throws DataError if the disk refuses.
class DiskFile {
  public:
    explicit DiskFile(const std::filesystem::path& file);
    ~DiskFile();
    DiskFile(const DiskFile&) = delete;
    DiskFile& operator=(const DiskFile&) = delete;
    void write(std::span<const unsigned char> bytes);
    void sync();

  private:
    std::filesystem::path file_;
    int descriptor_;
};

// Exclusive lock on a file. The operating system releases it however the process ends.
class FileLock {
  public:
    // Returns nothing if another process has the lock. Creates the file if it does not exist.
    static std::optional<FileLock> tryLock(const std::filesystem::path& file);
    FileLock(FileLock&&) noexcept;
    FileLock& operator=(FileLock&&) = delete;
    ~FileLock();

  private:
    explicit FileLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_;
};

// Syncs the file, also if another process wrote it. Throws DataError if the disk refuses.
void syncFile(const std::filesystem::path& file);
// Truncates the file to its first `bytes` bytes and syncs it.
void truncateFile(const std::filesystem::path& file, std::uint64_t bytes);

// Throws DataError with the reason if `folder` is not writable.
void checkWritable(const std::filesystem::path& folder);

// Syncs the folder's entries: created, renamed and removed names. Throws DataError if the disk refuses.
void syncFolder(const std::filesystem::path& folder);
// Also syncs every file and folder in it.
void syncTree(const std::filesystem::path& folder);

}  // namespace stylet::records
