// A program of ours run in a process of its own, with limits on what it may use.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace stylet::modeller {

// Bad input, or a child that gave up: what() is one sentence that names the file.
class ImportError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

struct ChildLimits {
    int wall_s = 120;
    int cpu_s = 90;
    std::size_t memory_bytes = std::size_t(3) << 30;
    std::size_t file_bytes = std::size_t(1) << 30;
};

// A folder that only this user can enter, gone with this object.
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

// `given`, or the program `name` beside this one. Throws ImportError where there is none.
std::filesystem::path childProgram(const std::filesystem::path& given, const std::string& name);

// Waits for it to end with success. Else throws ImportError: what it was `about`, and why `who` (a noun)
// failed or the one sentence it left on standard output.
void runChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
              const ChildLimits&, const std::string& about, const std::string& who);

}  // namespace stylet::modeller
