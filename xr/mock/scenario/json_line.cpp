#include "scenario/json_line.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace xrmock {

JsonLine& JsonLine::text(std::string_view value) {
    separate();
    const bool is_plain = std::all_of(value.begin(), value.end(),
                                      [](char c) { return c >= ' ' && c < '\x7f' && c != '"' && c != '\\'; });
    if (is_plain)
        text_.append("\"").append(value).append("\"");
    else  // invalid UTF-8 in names is replaced
        text_ += nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return *this;
}

JsonLine& JsonLine::pose(const Pose& pose) {
    open('[');
    for (const double each : pose.position)
        number(each);
    for (const double each : pose.orientation)
        number(each);
    return close(']');
}

}  // namespace xrmock
