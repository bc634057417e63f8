// Internal: reads a TOML table and rejects unknown keys. Every read states a range. Every error names the
// file, the field and the reason.
#pragma once

#include <toml++/toml.h>
#include <set>
#include <string>
#include <string_view>

#include "base/errors.h"

namespace stylet {

class TomlReader {
  public:
    TomlReader(const std::filesystem::path& file, std::string field, const toml::table& table)
        : file_(file), field_(std::move(field)), table_(table) {}

    [[noreturn]] void refuse(std::string_view key, const std::string& reason) const {
        throw DataError(file_, nameOf(key), reason);
    }
    bool has(std::string_view key) const { return table_.contains(key); }
    std::string nameOf(std::string_view key) const;

    // Throws DataError unless low <= value <= high. Integers are accepted.
    double number(std::string_view key, double low, double high);
    long long integer(std::string_view key, long long low, long long high);
    bool flag(std::string_view key);
    std::string text(std::string_view key, std::size_t max_bytes);
    TomlReader child(std::string_view key);
    // The elements of an array of tables; empty if the key is absent.
    std::vector<TomlReader> children(std::string_view key, std::size_t max_count);
    const toml::array& array(std::string_view key);

    // Throws DataError if the table has keys that were never read.
    void finish() const;

  private:
    const toml::node& take(std::string_view key);

    const std::filesystem::path& file_;
    std::string field_;
    const toml::table& table_;
    std::set<std::string, std::less<>> taken_;
};

// Throws DataError with the line of a syntax error.
toml::table parseToml(const std::filesystem::path& file, std::string_view text);

}  // namespace stylet
