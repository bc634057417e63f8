// Writes JSON on one line. The same values always produce the same bytes.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "scenario/pose.h"

namespace xrmock {

class JsonLine {
  public:
    JsonLine& key(std::string_view name) {
        text(name);
        text_ += ':';
        is_first_ = true;  // the value follows without a comma
        return *this;
    }
    JsonLine& open(char bracket) {  // '{' or '['
        separate();
        text_ += bracket;
        is_first_ = true;
        return *this;
    }
    JsonLine& close(char bracket) {
        text_ += bracket;
        is_first_ = false;
        return *this;
    }
    JsonLine& text(std::string_view value);
    // The shortest text that reads back to the same value.
    template <class Number>
    JsonLine& number(Number value) {
        separate();
        if constexpr (std::is_floating_point_v<Number>) {
            if (!std::isfinite(value)) {
                text_ += std::isnan(value) ? "\"nan\"" : value > 0 ? "\"inf\"" : "\"-inf\"";
                return *this;
            }
        }
        char buffer[32];
        text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
        return *this;
    }
    JsonLine& boolean(bool value) {
        separate();
        text_ += value ? "true" : "false";
        return *this;
    }
    JsonLine& null() {
        separate();
        text_ += "null";
        return *this;
    }
    JsonLine& raw(std::string_view value) {
        separate();
        text_ += value;
        return *this;
    }
    JsonLine& pose(const Pose& pose);  // [x, y, z, qx, qy, qz, qw]
    // Members of an object: names and values in turn. Enumerators are written as numbers.
    template <class Value, class... More>
    JsonLine& fields(std::string_view name, const Value& value, const More&... more) {
        key(name);
        if constexpr (std::is_same_v<Value, bool>) {
            boolean(value);
        } else if constexpr (std::is_same_v<Value, Pose>) {
            pose(value);
        } else if constexpr (std::is_convertible_v<const Value&, std::string_view>) {
            text(value);
        } else if constexpr (std::is_enum_v<Value>) {
            number(static_cast<std::int64_t>(value));
        } else {
            number(value);
        }
        if constexpr (sizeof...(more) > 0) fields(more...);
        return *this;
    }
    template <class... Fields>
    JsonLine& object(const Fields&... names_and_values) {
        return open('{').fields(names_and_values...).close('}');
    }

    const std::string& str() const { return text_; }
    void clear() {
        text_.clear();
        is_first_ = true;
    }

  private:
    void separate() {
        if (!is_first_) text_ += ',';
        is_first_ = false;
    }
    std::string text_;
    bool is_first_ = true;
};

}  // namespace xrmock
