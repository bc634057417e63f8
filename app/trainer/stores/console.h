// Text to and from the user's terminal.
#pragma once

#include <fmt/core.h>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "app/print.h"
#include "base/text.h"

namespace stylet::trainer {

// Prints a line on stderr, after "stylet: ".
inline void printMessage(const std::string& text) {
    std::fprintf(stderr, "stylet: %s\n", text.c_str());
}

// Removes the first complete line from `typed`. Returns it without leading and trailing blanks. Returns
// nothing if no line is complete.
inline std::optional<std::string> popLine(std::string& typed) {
    const std::size_t end = typed.find('\n');
    if (end == std::string::npos) return std::nullopt;
    std::string line(trimmed(std::string_view(typed).substr(0, end)));
    typed.erase(0, end + 1);
    return line;
}

// Line of a help text: the command in one column, its meaning in the next.
inline std::string helpLine(std::string_view command, std::string_view meaning) {
    return fmt::format("  {:<16}{}\n", command, meaning);
}

}  // namespace stylet::trainer
