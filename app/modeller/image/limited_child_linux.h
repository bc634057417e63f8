// Runs one of the modeller's programs in a process of its own, with resource limits.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace stylet::modeller {

struct ChildLimits {
    int wall_s = 120;
    int cpu_s = 90;
    std::size_t memory_bytes = std::size_t(3) << 30;
    std::size_t file_bytes = std::size_t(1) << 30;
};

// A temporary folder that only this user can access. The destructor deletes it.
class PrivateFolder {
  public:
    PrivateFolder();
    ~PrivateFolder();
    PrivateFolder(const PrivateFolder&) = delete;
    PrivateFolder& operator=(const PrivateFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

// Returns `given`. If it is empty, returns the installed program `name`. Throws EnvironmentError if it is
// missing.
std::filesystem::path childProgram(const std::filesystem::path& given, const std::string& name);

// Runs the program and waits until it ends. Throws ImportError if it fails, EnvironmentError if it cannot be
// started. The message names `about`, the file that the child works on, and then repeats the sentence that
// the child printed on standard output. If it printed none, the message says why the
// child failed; it calls the child `who`, for example "the reader".
void runChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
              const ChildLimits&, const std::string& about, const std::string& who);

}  // namespace stylet::modeller
