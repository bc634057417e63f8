// What survives a power loss: files and folders written through to the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

namespace stylet::records {

// A file made anew, or emptied when it exists. What is written is in the file at once, and on the disk after
// sync(). Throws patient::DataError when the disk refuses.
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

// Only this one holds the file's lock, which goes with the process however that ends.
class FileLock {
  public:
    // Nothing when another holds it. The file is made where there is none.
    static std::optional<FileLock> tryTake(const std::filesystem::path& file);
    FileLock(FileLock&&) noexcept;
    FileLock& operator=(FileLock&&) = delete;
    ~FileLock();

  private:
    explicit FileLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_;
};

// What was written into the file, by whomever. Throws patient::DataError when the disk refuses.
void syncFile(const std::filesystem::path& file);
// Cuts off what stands behind its first `bytes`, on the disk when it returns.
void cutFile(const std::filesystem::path& file, std::uint64_t bytes);

// Throws patient::DataError with the reason where nothing can be written into `folder`.
void checkWritable(const std::filesystem::path& folder);

// Names made, renamed or removed in `folder`. Throws patient::DataError when the disk refuses.
void syncFolder(const std::filesystem::path& folder);

}  // namespace stylet::records
