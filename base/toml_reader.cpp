#include "base/toml_reader.h"

#include <sstream>

namespace stylet {

std::string TomlReader::nameOf(std::string_view key) const {
    return field_.empty() ? std::string(key) : field_ + "." + std::string(key);
}

const toml::node& TomlReader::take(std::string_view key) {
    const toml::node* node = table_.get(key);
    if (!node) refuse(key, "missing");
    taken_.emplace(key);
    return *node;
}

double TomlReader::number(std::string_view key, double low, double high) {
    const toml::node& node = take(key);
    if (!node.is_number()) refuse(key, "not a number");
    const double value = *node.value<double>();
    if (!(value >= low && value <= high)) {
        std::ostringstream reason;
        reason << value << " is not in [" << low << ", " << high << "]";
        refuse(key, reason.str());
    }
    return value;
}

long long TomlReader::integer(std::string_view key, long long low, long long high) {
    const toml::node& node = take(key);
    if (!node.is_integer()) refuse(key, "not an integer");
    const long long value = node.as_integer()->get();
    if (value < low || value > high)
        refuse(key, std::to_string(value) + " is not in [" + std::to_string(low) + ", " +
                        std::to_string(high) + "]");
    return value;
}

bool TomlReader::flag(std::string_view key) {
    const toml::node& node = take(key);
    if (!node.is_boolean()) refuse(key, "not true or false");
    return node.as_boolean()->get();
}

std::string TomlReader::text(std::string_view key, std::size_t max_bytes) {
    const toml::node& node = take(key);
    if (!node.is_string()) refuse(key, "not a string");
    const std::string& value = node.as_string()->get();
    if (value.size() > max_bytes) refuse(key, "longer than " + std::to_string(max_bytes) + " bytes");
    return value;
}

TomlReader TomlReader::child(std::string_view key) {
    const toml::node& node = take(key);
    if (!node.is_table()) refuse(key, "not a table");
    return {file_, nameOf(key), *node.as_table()};
}

std::vector<TomlReader> TomlReader::children(std::string_view key, std::size_t max_count) {
    if (!has(key)) return {};
    const toml::array& entries = array(key);
    if (entries.size() > max_count) refuse(key, "more than " + std::to_string(max_count) + " entries");
    std::vector<TomlReader> readers;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const std::string name = nameOf(key) + "[" + std::to_string(i) + "]";
        if (!entries[i].is_table()) throw DataError(file_, name, "not a table");
        readers.emplace_back(file_, name, *entries[i].as_table());
    }
    return readers;
}

const toml::array& TomlReader::array(std::string_view key) {
    const toml::node& node = take(key);
    if (!node.is_array()) refuse(key, "not an array");
    return *node.as_array();
}

void TomlReader::finish() const {
    for (const auto& [key, node] : table_)
        if (!taken_.contains(key.str())) refuse(key.str(), "unknown key");
}

toml::table parseToml(const std::filesystem::path& file, std::string_view text) {
    try {
        return toml::parse(text);
    } catch (const toml::parse_error& e) {
        throw DataError(file, "line " + std::to_string(e.source().begin.line), std::string(e.description()));
    }
}

}  // namespace stylet
