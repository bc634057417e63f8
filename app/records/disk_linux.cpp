#include "app/records/disk_linux.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "patient/package/package.h"

namespace stylet::records {

DiskFile::DiskFile(const std::filesystem::path& file)
    : file_(file), descriptor_(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)) {
    if (descriptor_ < 0) throw DataError(file_, "file", std::strerror(errno));
}

DiskFile::~DiskFile() {
    close(descriptor_);
}

void DiskFile::write(std::span<const unsigned char> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) throw DataError(file_, "file", std::strerror(errno));
        bytes = bytes.subspan(std::size_t(written));
    }
}

void DiskFile::sync() {
    // EINVAL: a pipe or a similar file that cannot be synced.
    if (fdatasync(descriptor_) != 0 && errno != EINVAL) throw DataError(file_, "file", std::strerror(errno));
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock::~FileLock() {
    if (descriptor_ >= 0) close(descriptor_);
}

std::optional<FileLock> FileLock::tryTake(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor < 0) throw DataError(file, "file", std::strerror(errno));
    FileLock lock(descriptor);
    if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return lock;
    if (errno == EWOULDBLOCK) return std::nullopt;
    throw DataError(file, "lock", std::strerror(errno));
}

void checkWritable(const std::filesystem::path& folder) {
    if (access(folder.c_str(), W_OK | X_OK) != 0)
        throw DataError(folder, "folder", std::string("cannot be written to: ") + std::strerror(errno));
}

void syncFile(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) throw DataError(file, "file", std::strerror(errno));
    const int error = fdatasync(descriptor) == 0 ? 0 : errno;
    close(descriptor);
    if (error != 0 && error != EINVAL) throw DataError(file, "file", std::strerror(error));
}

void cutFile(const std::filesystem::path& file, std::uint64_t bytes) {
    if (truncate(file.c_str(), off_t(bytes)) != 0) throw DataError(file, "file", std::strerror(errno));
    syncFile(file);
}

void syncFolder(const std::filesystem::path& folder) {
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) throw DataError(folder, "folder", std::strerror(errno));
    const int error = fsync(descriptor) == 0 ? 0 : errno;
    close(descriptor);
    // EINVAL: a file system that does not need folder syncs.
    if (error != 0 && error != EINVAL) throw DataError(folder, "folder", std::strerror(error));
}

}  // namespace stylet::records
