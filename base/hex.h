// Numbers as hexadecimal text.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace stylet {

inline constexpr std::size_t kHexDigits = 16;  // of a 64-bit number

// The lowest `digits` digits in lower case, with leading zeros.
inline std::string hexText(std::uint64_t value, std::size_t digits = kHexDigits) {
    std::string text(digits, '0');
    for (std::size_t i = digits; i-- > 0; value >>= 4)
        text[i] = "0123456789abcdef"[value & 15];
    return text;
}

// Parses exactly 16 digits of either case, without prefix or sign.
inline std::optional<std::uint64_t> parseHex(std::string_view text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
    if (text.size() != kHexDigits || error != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

}  // namespace stylet
