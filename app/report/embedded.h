// Files embedded in the program (cmake/Embed.cmake): those that every page contains, and the glossary.
#pragma once

#include <string_view>

namespace stylet::report {

struct Embedded {
    std::string_view text;
    std::string_view sha256;  // hexadecimal
};

Embedded chartJs();     // chart.js as its package ships it, including the licence line
Embedded pageJs();      // page.js
Embedded pageCss();     // page.css
Embedded glossaryMd();  // packaging/guide/glossary.md

}  // namespace stylet::report
