// Recognises UTF-8.
#pragma once

#include <cstddef>
#include <string_view>

namespace stylet {

// Length of the well-formed UTF-8 character at the start of `s`, or 0 if there is none.
inline std::size_t utf8Length(std::string_view s) {
    const auto byte = [&](std::size_t i) {
        return i < s.size() ? unsigned(static_cast<unsigned char>(s[i])) : 0u;
    };
    const auto tail = [&](std::size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
    const unsigned a = byte(0), b = byte(1);
    if (a < 0x80u) return 1;
    if (a >= 0xC2u && a <= 0xDFu) return tail(1) ? 2 : 0;
    if (a >= 0xE0u && a <= 0xEFu) {
        const bool overlong = a == 0xE0u && b < 0xA0u, surrogate = a == 0xEDu && b >= 0xA0u;
        return tail(1) && tail(2) && !overlong && !surrogate ? 3 : 0;
    }
    if (a >= 0xF0u && a <= 0xF4u) {
        const bool overlong = a == 0xF0u && b < 0x90u, beyond = a == 0xF4u && b >= 0x90u;
        return tail(1) && tail(2) && tail(3) && !overlong && !beyond ? 4 : 0;
    }
    return 0;
}

inline bool isUtf8(std::string_view text) {
    while (!text.empty()) {
        const std::size_t length = utf8Length(text);
        if (length == 0) return false;
        text.remove_prefix(length);
    }
    return true;
}

}  // namespace stylet
