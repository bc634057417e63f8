// Who may read files: the process's umask, and the entries that group or others can access.
#pragma once

#include <fmt/core.h>
#include <sys/stat.h>

#include <filesystem>
#include <string>

namespace stylet::test {

// Scope in which new files are open to everyone, unless their creator asks for less.
class PermissiveUmask {
  public:
    PermissiveUmask() : before_(umask(0)) {}
    ~PermissiveUmask() { umask(before_); }
    PermissiveUmask(const PermissiveUmask&) = delete;
    PermissiveUmask& operator=(const PermissiveUmask&) = delete;

  private:
    mode_t before_;
};

// "NAME MODE; " for each entry of the tree that is neither a private folder (0700) nor a private file (0600).
// Symbolic links are left out.
inline std::string openEntries(const std::filesystem::path& tree) {
    std::string text;
    const auto check = [&](const std::filesystem::path& path) {
        struct stat now{};
        if (lstat(path.c_str(), &now) != 0 || S_ISLNK(now.st_mode)) return;
        if ((now.st_mode & 07777) != (S_ISDIR(now.st_mode) ? 0700u : 0600u))
            text += fmt::format("{} {:o}; ", path.filename().string(), now.st_mode & 07777);
    };
    check(tree);
    if (std::filesystem::is_directory(tree))
        for (const auto& entry : std::filesystem::recursive_directory_iterator(tree))
            check(entry.path());
    return text;
}

}  // namespace stylet::test
