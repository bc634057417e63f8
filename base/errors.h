// Error types by cause. A program prints what(); the type determines its exit status.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace stylet {

// The command line asks for something that does not exist. Exit status 100.
class UsageError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// Invalid data. what() reads "FILE: FIELD: reason". Exit status 2, like every other error.
class DataError : public std::runtime_error {
  public:
    DataError(const std::filesystem::path& file, const std::string& field, const std::string& reason)
        : std::runtime_error(file.string() + ": " + field + ": " + reason) {}
};

// Something outside the program fails: a GPU, an OpenXR runtime, a device, a server, a window. what() names
// the failed call, its error code and, where there is one, the cure. Exit status 3.
class EnvironmentError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

}  // namespace stylet
