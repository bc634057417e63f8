// Reads a text file line by line. Errors name the line. Used by the CSV readers. Accepts the byte order mark
// that spreadsheets write at the start of UTF-8.
#pragma once

#include <string>
#include <string_view>

#include "base/errors.h"

namespace stylet {

// `file` and `text` must outlive the reader.
class LineReader {
  public:
    LineReader(const std::filesystem::path& file, std::string_view text) : file_(file), rest_(text) {
        if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    }

    bool done() const { return rest_.empty(); }
    // The next line without its line ending (LF, CR LF or CR).
    std::string_view next() {
        ++line_;
        const std::string_view line = rest_.substr(0, rest_.find_first_of("\r\n"));
        rest_.remove_prefix(line.size());
        rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : rest_.empty() ? 0 : 1);
        return line;
    }
    // Throws DataError for the line that next() returned last.
    [[noreturn]] void refuse(const std::string& reason) const {
        throw DataError(file_, "line " + std::to_string(line_), reason);
    }

  private:
    static constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

    const std::filesystem::path& file_;
    std::string_view rest_;
    std::size_t line_ = 0;
};

}  // namespace stylet
