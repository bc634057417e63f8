// Reads and writes tables of comma-separated values.
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "base/line_reader.h"
#include "base/text.h"

namespace stylet {

// Reads a table without quoted cells, row by row. Every row must have exactly the columns of the header.
// Throws DataError, naming the line and the column.
class CsvReader {
  public:
    // `columns`: the expected header. `file`, `text` and `columns` must outlive the reader.
    CsvReader(const std::filesystem::path& file, std::string_view text, std::string_view columns,
              char separator = ',')
        : lines_(file, text), columns_(columns), separator_(separator) {
        if (lines_.next() != columns) lines_.refuse("the columns are not " + std::string(columns));
    }

    // Moves to the next row. Returns false at the end of the table.
    bool next() {
        if (lines_.done()) return false;
        row_ = lines_.next();
        const std::size_t fields = countFields(row_), expected = countFields(columns_);
        if (fields != expected) lines_.refuse(fmt::format("{} fields, not {}", fields, expected));
        names_ = columns_;
        return true;
    }

    // The functions below return the next field of the row.
    std::string_view text() {
        name_ = split(names_);
        return split(row_);
    }
    template <typename Number>
    Number number(Number low = std::numeric_limits<Number>::lowest(),
                  Number high = std::numeric_limits<Number>::max()) {
        const std::string_view field = text();
        const auto value = parseNumber<Number>(field);
        if (!value) refuse(fmt::format("\"{}\" is not a number", field.substr(0, 40)));
        if (!(*value >= low && *value <= high))  // !(...) also refuses NaN
            refuse(fmt::format("{} is not from {} to {}", field.substr(0, 40), shortestText(low),
                               shortestText(high)));
        return *value;
    }

    // Throws DataError for the field that was read last, or for the whole row.
    [[noreturn]] void refuse(const std::string& reason) const {
        lines_.refuse(fmt::format("{}: {}", name_, reason));
    }
    [[noreturn]] void refuseRow(const std::string& reason) const { lines_.refuse(reason); }

  private:
    std::size_t countFields(std::string_view row) const {
        std::size_t fields = 1;
        for (const char c : row)
            fields += c == separator_;
        return fields;
    }
    std::string_view split(std::string_view& row) const {
        const std::size_t end = row.find(separator_);
        const std::string_view field = row.substr(0, end);
        row.remove_prefix(end == std::string_view::npos ? row.size() : end + 1);
        return field;
    }

    LineReader lines_;
    std::string_view columns_, row_, names_, name_;
    char separator_;
};

// The cells separated by commas, quoted where necessary, without a line ending. A text that a spreadsheet
// would evaluate as a formula gets a leading apostrophe.
std::string csvRow(std::span<const std::string> cells);

}  // namespace stylet
