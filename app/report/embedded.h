// Files that the program carries (cmake/Embed.cmake): what every page has in it.
#pragma once

#include <string_view>

namespace stylet::report {

struct Embedded {
    std::string_view text;
    std::string_view sha256;  // hexadecimal
};

Embedded chartJs();  // chart.js as its package ships it, licence line included
Embedded pageJs();   // page.js
Embedded pageCss();  // page.css

}  // namespace stylet::report
