// Reads a text file line by line. Errors name the line. Used by the CSV readers.
#pragma once

#include <string>
#include <string_view>

#include "base/errors.h"

namespace stylet {

// `file` and `text` must outlive the reader.
class LineReader {
  public:
    LineReader(const std::filesystem::path& file, std::string_view text) : file_(file), rest_(text) {}

    bool done() const { return rest_.empty(); }
    // The next line without its line ending (LF or CR LF).
    std::string_view next() {
        ++line_;
        const std::size_t end = rest_.find('\n');
        std::string_view line = rest_.substr(0, end);
        rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
        if (line.ends_with('\r')) line.remove_suffix(1);
        return line;
    }
    // Throws DataError for the line that next() returned last.
    [[noreturn]] void refuse(const std::string& reason) const {
        throw DataError(file_, "line " + std::to_string(line_), reason);
    }

  private:
    const std::filesystem::path& file_;
    std::string_view rest_;
    std::size_t line_ = 0;
};

}  // namespace stylet
