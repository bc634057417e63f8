// Numbers as text and back, independent of the locale. Other text is formatted with fmt::format().
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace stylet {

// Parses a text that is one decimal number and nothing else. "inf" and "nan" are numbers.
template <typename Number>
std::optional<Number> parseNumber(std::string_view text) {
    Number value{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || stop != end) return std::nullopt;
    return value;
}

// The fewest digits that parse to the same bits.
template <typename Number>
std::string shortestText(Number value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

// enumName() returns the name of a value, or "?" if it has none. findEnum() returns the value with this name.
// `names` are in the order of the values.
template <typename Enum, std::size_t N>
constexpr std::string_view enumName(const std::array<std::string_view, N>& names, Enum value) noexcept {
    return std::size_t(value) < N ? names[std::size_t(value)] : "?";
}
template <typename Enum, std::size_t N>
constexpr std::optional<Enum> findEnum(const std::array<std::string_view, N>& names, std::string_view name) {
    for (std::size_t i = 0; i < N; ++i)
        if (names[i] == name) return Enum(i);
    return std::nullopt;
}

// The text with its first letter in upper case, if that is one of ASCII.
inline std::string capitalised(std::string_view text) {
    std::string upper(text);
    if (!upper.empty() && upper.front() >= 'a' && upper.front() <= 'z')
        upper.front() = char(upper.front() - 'a' + 'A');
    return upper;
}

// The text without leading and trailing blanks (spaces, tabs, carriage returns).
inline std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    const std::size_t first = text.find_first_not_of(kBlanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace stylet
