#include "app/records/disk_linux.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "patient/package/package.h"

namespace stylet::records {

namespace {

namespace fs = std::filesystem;

constexpr mode_t kFileMode = 0600, kFolderMode = 0700, kOthers = 0077;

[[noreturn]] void throwErrno(const std::filesystem::path& path, const char* field = "file") {
    throw DataError(path, field, std::strerror(errno));
}

// Opens the path, passes it to `sync` and closes it.
void syncPath(const std::filesystem::path& path, int flags, int (*sync)(int), const char* field) {
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | flags);
    if (descriptor < 0) throwErrno(path, field);
    const int error = sync(descriptor) == 0 ? 0 : errno;
    close(descriptor);
    errno = error;
    // EINVAL: a pipe, or a folder on a file system that cannot sync folders.
    if (error != 0 && error != EINVAL) throwErrno(path, field);
}

}  // namespace

void makeNewFilesPrivate() {
    umask(kOthers);
}

void createPrivateFolders(const fs::path& folder) {
    fs::path path;
    for (const fs::path& name : folder) {
        path /= name;
        if (fs::is_directory(path) || mkdir(path.c_str(), kFolderMode) == 0) continue;
        const int error = errno;
        if (fs::is_directory(path)) continue;  // another process created it meanwhile
        errno = error;
        throwErrno(folder, "folder");
    }
}

void createPrivateFile(const fs::path& file) {
    const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode);
    if (descriptor >= 0)
        close(descriptor);
    else if (errno != EEXIST)
        throwErrno(file);
}

bool makePrivate(const fs::path& path) {
    struct stat now{};
    if (lstat(path.c_str(), &now) != 0) {
        if (errno == ENOENT) return false;  // another process may have removed it
        throwErrno(path, "permissions");
    }
    const bool ours = S_ISREG(now.st_mode) || S_ISDIR(now.st_mode);
    if (!ours || (now.st_mode & kOthers) == 0) return false;
    if (chmod(path.c_str(), now.st_mode & 07777u & ~kOthers) != 0 && errno != ENOENT)
        throwErrno(path, "permissions");
    return true;
}

std::size_t makeTreePrivate(const fs::path& folder) {
    // Tighten the folder first: then other users can no longer reach its contents.
    std::size_t changed = makePrivate(folder);
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error))
        changed += entry.is_directory() && !entry.is_symlink() ? makeTreePrivate(entry.path())
                                                               : std::size_t(makePrivate(entry.path()));
    // Another process may have removed the folder meanwhile.
    if (error && error != std::errc::no_such_file_or_directory)
        throw DataError(folder, "permissions", error.message());
    return changed;
}

DiskFile::DiskFile(const std::filesystem::path& file)
    : file_(file), descriptor_(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kFileMode)) {
    if (descriptor_ < 0) throwErrno(file_);
    // A file that was there before has its old mode. A pipe or device is left alone.
    struct stat now{};
    if (fstat(descriptor_, &now) == 0 && S_ISREG(now.st_mode) && (now.st_mode & kOthers) != 0)
        fchmod(descriptor_, kFileMode);
}

DiskFile::~DiskFile() {
    close(descriptor_);
}

void DiskFile::write(std::span<const unsigned char> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) throwErrno(file_);
        bytes = bytes.subspan(std::size_t(written));
    }
}

void DiskFile::sync() {
    // EINVAL: a pipe or a similar file that cannot be synced.
    if (fdatasync(descriptor_) != 0 && errno != EINVAL) throwErrno(file_);
}

FileLock::FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileLock::~FileLock() {
    if (descriptor_ >= 0) close(descriptor_);
}

std::optional<FileLock> FileLock::tryLock(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kFileMode);
    if (descriptor < 0) throwErrno(file);
    FileLock lock(descriptor);
    if (flock(descriptor, LOCK_EX | LOCK_NB) == 0) return lock;
    if (errno == EWOULDBLOCK) return std::nullopt;
    throwErrno(file, "lock");
}

void checkWritable(const std::filesystem::path& folder) {
    if (access(folder.c_str(), W_OK | X_OK) != 0)
        throw DataError(folder, "folder", std::string("cannot be written to: ") + std::strerror(errno));
}

void syncFile(const std::filesystem::path& file) {
    syncPath(file, 0, &fdatasync, "file");
}

void truncateFile(const std::filesystem::path& file, std::uint64_t bytes) {
    if (truncate(file.c_str(), off_t(bytes)) != 0) throwErrno(file);
    syncFile(file);
}

void syncFolder(const std::filesystem::path& folder) {
    syncPath(folder, O_DIRECTORY, &fsync, "folder");
}

void syncTree(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.is_directory())
            syncTree(entry.path());
        else if (entry.is_regular_file())
            syncFile(entry.path());
    }
    syncFolder(folder);
}

}  // namespace stylet::records
