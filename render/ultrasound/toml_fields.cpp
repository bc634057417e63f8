#include "render/ultrasound/toml_fields.h"

#include "patient/package/package.h"

namespace stylet::render {

toml::table parseToml(const std::filesystem::path& file, std::string_view text) {
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& e) {
        throw DataError(file, "line " + std::to_string(e.source().begin.line), std::string(e.description()));
    }
}

std::string TomlFields::field(std::string_view key) const {
    return where.empty() ? std::string(key) : where + "." + std::string(key);
}

void TomlFields::refuse(std::string_view key, const std::string& reason) const {
    throw DataError(file, field(key), reason);
}

double TomlFields::number(std::string_view key, double low, double high) const {
    const toml::node* node = table.get(key);
    const auto value = node ? node->value<double>() : std::nullopt;
    if (!value) refuse(key, "missing, or not a number");
    if (!(*value >= low && *value <= high))
        refuse(key, std::to_string(*value) + " is not within " + std::to_string(low) + " to " +
                        std::to_string(high));
    return *value;
}

double TomlFields::numberOr(std::string_view key, double low, double high, double absent) const {
    return table.contains(key) ? number(key, low, high) : absent;
}

std::string TomlFields::text(std::string_view key) const {
    const toml::node* node = table.get(key);
    const auto value = node ? node->value<std::string>() : std::nullopt;
    if (!value || value->empty()) refuse(key, "missing, or not a text");
    return *value;
}

std::string TomlFields::textOr(std::string_view key, const std::string& absent) const {
    return table.contains(key) ? text(key) : absent;
}

}  // namespace stylet::render
