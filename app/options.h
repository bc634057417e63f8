// Checks of command-line options that CLI11 lacks.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "base/text.h"

namespace stylet {

// Checks that the option's value is from `low` to `high`. Unlike CLI::Range, refuses NaN.
template <typename Number>
CLI::Validator inRange(Number low, Number high) {
    const std::string from = shortestText(low), to = shortestText(high);
    const auto check = [=](const std::string& text) {
        Number value{};
        const bool inside = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return inside ? std::string() : text + " is not in " + from + " to " + to;
    };
    return {check, std::string(CLI::detail::type_name<Number>()) + " in [" + from + " - " + to + "]", ""};
}

}  // namespace stylet
