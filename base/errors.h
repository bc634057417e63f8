// Errors by cause. what() is the sentence that a program prints.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace stylet {

// Invalid data. what() reads "FILE: FIELD: reason".
class DataError : public std::runtime_error {
  public:
    DataError(const std::filesystem::path& file, const std::string& field, const std::string& reason)
        : std::runtime_error(file.string() + ": " + field + ": " + reason) {}
};

}  // namespace stylet
