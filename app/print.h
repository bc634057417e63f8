// Prints on the standard streams. Unlike fmt::print(), ignores write errors, so that a closed or full stream
// does not end the work. runProgram() checks stdout when the program ends (program_linux.h).
#pragma once

#include <fmt/core.h>
#include <cstdio>
#include <utility>

namespace stylet {

template <typename... Values>
void printResult(fmt::format_string<Values...> format, Values&&... values) {
    std::fputs(fmt::format(format, std::forward<Values>(values)...).c_str(), stdout);
}
template <typename... Values>
void printProgress(fmt::format_string<Values...> format, Values&&... values) {
    std::fputs(fmt::format(format, std::forward<Values>(values)...).c_str(), stderr);
}

}  // namespace stylet
