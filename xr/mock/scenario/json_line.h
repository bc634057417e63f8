// Writes JSON on one line. The same values always produce the same bytes.
#pragma once

#include <charconv>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>

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
    template <std::integral Number>
    JsonLine& number(Number value) {
        separate();
        char buffer[24];
        text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
        return *this;
    }
    JsonLine& number(double value) {  // shortest text that reads back to the same value
        separate();
        if (!std::isfinite(value)) {
            text_ += std::isnan(value) ? "\"nan\"" : value > 0 ? "\"inf\"" : "\"-inf\"";
            return *this;
        }
        char buffer[32];
        text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
        return *this;
    }
    JsonLine& number(float value) {
        if (!std::isfinite(value)) return number(static_cast<double>(value));
        separate();
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
