// What survives a power loss: files and folders written through to the disk.
#pragma once

#include <filesystem>
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

// Names made, renamed or removed in `folder`. Throws patient::DataError when the disk refuses.
void syncFolder(const std::filesystem::path& folder);

}  // namespace stylet::records
