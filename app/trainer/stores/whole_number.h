// Parses a text that is a whole number and nothing else.
#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string_view>

namespace stylet::trainer {

inline std::optional<std::size_t> wholeNumberIn(std::string_view text) {
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

}  // namespace stylet::trainer
