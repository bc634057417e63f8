#include "scenario/json_fields.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

namespace xrmock {

using nlohmann::json;

namespace {
constexpr int kMaxDepth = 32;
}

json parseJson(const std::string& text, const std::string& source) {
    std::vector<std::set<std::string>> names;  // names in the open objects, innermost last
    const auto watch = [&](int depth, json::parse_event_t event, const json& value) {
        if (depth > kMaxDepth) throw FieldError(source + ": document: nested too deeply");
        if (event == json::parse_event_t::object_start) names.emplace_back();
        if (event == json::parse_event_t::object_end) names.pop_back();
        if (event == json::parse_event_t::key && !names.back().insert(value.get<std::string>()).second)
            throw FieldError(source + ": " + value.get<std::string>() + ": there twice");
        return true;
    };
    try {
        return json::parse(text, watch);
    } catch (const json::exception& error) {
        const std::string what = error.what();  // "[json.exception.parse_error.101] parse error at line ..."
        throw FieldError(source + ": document: " + what.substr(what.find(']') + 2));
    }
}

std::string readTextFile(const std::string& file_name) {
    std::error_code unreadable;
    if (!std::filesystem::is_regular_file(file_name, unreadable))
        throw FieldError(file_name + ": document: cannot be read");
    if (std::filesystem::file_size(file_name, unreadable) > kMaxFileBytes)
        throw FieldError(file_name + ": document: larger than 64 MiB");
    std::ifstream file(file_name, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (!file || text.empty()) throw FieldError(file_name + ": document: cannot be read");
    return text;
}

void Field::fail(const std::string& reason) const {
    throw FieldError(source + ": " + (name.empty() ? "document" : name) + ": " + reason);
}

Field Field::at(const std::string& key) const {
    return {value.at(key), source, name.empty() ? key : name + "." + key};
}

Field Field::at(std::size_t index) const {
    return {value.at(index), source, name + "[" + std::to_string(index) + "]"};
}

Field Field::required(const char* key) const {
    if (!has(key)) fail(std::string(key) + " is missing");
    return at(key);
}

void Field::requireObject() const {
    if (!value.is_object()) fail("an object expected");
}

void Field::requireObject(std::initializer_list<const char*> keys) const {
    requireObject();
    for (const auto& [key, unused] : value.items())
        if (std::find(keys.begin(), keys.end(), key) == keys.end()) at(key).fail("unknown field");
}

std::string Field::onlyKey(std::initializer_list<const char*> others, std::span<const char* const> kinds,
                           const std::string& noun) const {
    std::string kind;
    for (const auto& [key, unused] : value.items()) {
        if (std::find(others.begin(), others.end(), key) != others.end()) continue;
        if (std::find(kinds.begin(), kinds.end(), key) == kinds.end()) at(key).fail("unknown field");
        if (!kind.empty()) fail("one " + noun + " at a time expected, not " + kind + " and " + key);
        kind = key;
    }
    if (kind.empty()) fail("an " + noun + " expected");
    return kind;
}

std::size_t Field::arraySize(std::size_t max_size) const {
    if (!value.is_array()) fail("an array expected");
    if (value.size() > max_size) fail("at most " + std::to_string(max_size) + " elements expected");
    return value.size();
}

double Field::number(double low, double high) const {
    if (!value.is_number()) fail("a number expected");
    const double number = value.get<double>();
    if (!(number >= low && number <= high)) {
        std::ostringstream range;
        range << "a number from " << low << " to " << high << " expected";
        fail(range.str());
    }
    return number;
}

std::uint64_t Field::integer(std::uint64_t low, std::uint64_t high) const {
    const double whole = number(static_cast<double>(low), static_cast<double>(high));
    if (whole != std::floor(whole)) fail("a whole number expected");
    return static_cast<std::uint64_t>(whole);
}

bool Field::boolean() const {
    if (!value.is_boolean()) fail("true or false expected");
    return value.get<bool>();
}

std::string Field::text() const {
    if (!value.is_string()) fail("a string expected");
    const auto& text = value.get_ref<const std::string&>();
    if (text.size() > kMaxText) fail("at most " + std::to_string(kMaxText) + " bytes expected");
    if (text.find('\0') != std::string::npos) fail("a string without null characters expected");
    return text;
}

std::size_t Field::oneOf(std::initializer_list<const char*> names) const {
    const std::string given = text();
    const auto found = std::find(names.begin(), names.end(), given);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    std::string list;
    for (auto each = names.begin(); each != names.end(); ++each)
        list += (each == names.begin() ? "" : each + 1 == names.end() ? " or " : ", ") + std::string(*each);
    fail(list + " expected");
}

}  // namespace xrmock
