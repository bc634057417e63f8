// Strict JSON reader for scenarios, headsets and control messages. Refuses unknown fields, wrong types,
// numbers out of range and excessive sizes. The error names the source, the path of the field and the reason.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace xrmock {

// One line: source, field, reason.
class FieldError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

constexpr double kMaxNumber = 1e9;
constexpr std::size_t kMaxElements = 1'000'000;     // of one array
constexpr std::size_t kMaxText = 4096;              // bytes of one string
constexpr std::size_t kMaxFileBytes = 64U << 20;    // of one file
constexpr std::size_t kMaxMessageBytes = 1U << 20;  // of one control message

// Refuses invalid JSON, nesting deeper than 32 levels and duplicate names. Error messages start with
// `source`.
nlohmann::json parseJson(const std::string& text, const std::string& source);
// The bytes of a regular file. Throws FieldError.
std::string readTextFile(const std::string& file_name);

// A JSON value with its source and path.
struct Field {
    const nlohmann::json& value;
    const std::string& source;
    std::string name;

    [[noreturn]] void fail(const std::string& reason) const;
    // The member must exist: check it with has(), or call required().
    Field at(const std::string& key) const;
    Field at(std::size_t index) const;
    bool has(const char* key) const { return value.contains(key); }
    Field required(const char* key) const;

    void requireObject(std::initializer_list<const char*> keys) const;
    void requireObject() const;
    // Returns the object's only key that is not in `others`. It must be one of `kinds`. Error messages call
    // such a key `noun`.
    std::string onlyKey(std::initializer_list<const char*> others, std::span<const char* const> kinds,
                        const std::string& noun) const;
    std::size_t arraySize(std::size_t max_size = kMaxElements) const;
    double number(double low, double high) const;
    std::uint64_t integer(std::uint64_t low, std::uint64_t high) const;
    bool boolean() const;
    std::string text() const;
    // Returns the index of the text in `names`.
    std::size_t oneOf(std::initializer_list<const char*> names) const;

    template <std::size_t kSize>
    std::array<double, kSize> numbers(double low, double high) const {
        if (arraySize() != kSize) fail(std::to_string(kSize) + " numbers expected");
        std::array<double, kSize> result;
        for (std::size_t i = 0; i < kSize; ++i)
            result[i] = at(i).number(low, high);
        return result;
    }
};

}  // namespace xrmock
