// Follows the output of a running program.
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

#include "tests/support/file_text.h"
#include "tests/support/nap.h"

namespace stylet::test {

// Searches text that grows. Each search begins after the previous match.
class ProgramOutput {
  public:
    explicit ProgramOutput(std::function<std::string()> read) : read_(std::move(read)) {}
    explicit ProgramOutput(const std::filesystem::path& file) : read_([file] { return readText(file); }) {}

    std::string text() const { return read_(); }
    bool contains(const std::string& words) {
        const std::size_t found = text().find(words, searched_);
        if (found == std::string::npos) return false;
        searched_ = found + words.size();
        return true;
    }
    // Waits until the output contains `words`. Returns false after `limit`.
    bool waitFor(const std::string& words, std::chrono::milliseconds limit = std::chrono::seconds(60)) {
        const auto end = std::chrono::steady_clock::now() + limit;
        for (; !contains(words); sleepMs(20))
            if (std::chrono::steady_clock::now() > end) return false;
        return true;
    }
    // Like waitFor(), but throws std::runtime_error after `limit`.
    void require(const std::string& words, std::chrono::milliseconds limit = std::chrono::seconds(60)) {
        if (!waitFor(words, limit)) throw std::runtime_error("never printed: " + words + "\n" + text());
    }

  private:
    std::function<std::string()> read_;
    std::size_t searched_ = 0;
};

}  // namespace stylet::test
