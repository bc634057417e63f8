#include "json_line.h"

namespace xrmock {

JsonLine& JsonLine::text(std::string_view value) {
    constexpr char kDigits[] = "0123456789abcdef";
    separate();
    text_ += '"';
    for (const char c : value) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') {
            text_ += '\\';
            text_ += c;
        } else if (byte < 0x20 ||
                   byte >= 0x7f) {  // names may hold any bytes: each as the character of its number
            text_ += "\\u00";
            text_ += kDigits[byte >> 4];
            text_ += kDigits[byte & 15];
        } else {
            text_ += c;
        }
    }
    text_ += '"';
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
