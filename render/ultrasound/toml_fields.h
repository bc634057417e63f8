// Reads fields of a TOML table. Errors name file, field and reason.
#pragma once

#include <toml++/toml.h>
#include <filesystem>
#include <string>
#include <string_view>

namespace stylet::render {

inline constexpr double kMm = 1e-3;  // in metres

toml::table parseToml(const std::filesystem::path& file, std::string_view text);

// A table and its place in a file. All functions throw DataError.
struct TomlFields {
    const std::filesystem::path& file;
    std::string where;  // "tissue[3]", empty for the root
    const toml::table& table;

    std::string field(std::string_view key) const;
    double number(std::string_view key, double low, double high) const;
    double numberOr(std::string_view key, double low, double high, double absent) const;
    std::string text(std::string_view key) const;  // not empty
    std::string textOr(std::string_view key, const std::string& absent) const;
    [[noreturn]] void refuse(std::string_view key, const std::string& reason) const;

    // Calls visit(TomlFields) for each of [[key]].
    template <typename Visit>
    void each(std::string_view key, const Visit& visit) const {
        const toml::node* node = table.get(key);
        const toml::array* list = node ? node->as_array() : nullptr;
        if (node && !list) refuse(key, "not an array of tables");
        std::size_t i = 0;
        if (list)
            for (const toml::node& entry : *list) {
                const std::string at = std::string(key) + "[" + std::to_string(i++) + "]";
                if (!entry.is_table()) refuse(at, "not a table");
                visit(TomlFields{file, at, *entry.as_table()});
            }
    }
};

}  // namespace stylet::render
