#include "base/csv.h"

namespace stylet {

namespace {

bool looksLikeFormula(std::string_view text) {
    return !text.empty() && std::string_view("=+-@\t\r").find(text[0]) != std::string_view::npos &&
           !parseNumber<double>(text);
}

}  // namespace

std::string csvRow(std::span<const std::string> cells) {
    std::string row;
    for (const std::string& cell : cells) {
        if (&cell != cells.data()) row += ',';
        const std::string text = looksLikeFormula(cell) ? "'" + cell : cell;
        if (text.find_first_of(",\"\r\n") == std::string::npos) {
            row += text;
            continue;
        }
        row += '"';
        for (const char c : text)
            row += c == '"' ? "\"\"" : std::string(1, c);
        row += '"';
    }
    return row;
}

}  // namespace stylet
