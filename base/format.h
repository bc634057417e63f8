// printf into a string.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace stylet {

// Returns the text that std::printf would print.
[[gnu::format(printf, 1, 2)]] inline std::string formatted(const char* format, ...) {
    std::va_list first, second;
    va_start(first, format);
    va_copy(second, first);
    const int length = std::vsnprintf(nullptr, 0, format, first);
    va_end(first);
    std::string text(length > 0 ? std::size_t(length) : 0, '\0');
    std::vsnprintf(text.data(), text.size() + 1, format, second);
    va_end(second);
    return text;
}

}  // namespace stylet
