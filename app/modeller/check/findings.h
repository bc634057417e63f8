// Internal: the list of findings that the checks fill.
#pragma once

#include <fmt/core.h>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "app/modeller/check/check_package.h"

namespace stylet::modeller {

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

struct Range {
    double low = -kUnbounded, high = kUnbounded;
};

inline std::string formatNumber(double v) {
    return fmt::format("{:.4g}", v);
}

class Findings {
  public:
    enum Grade { warned, refused };

    // Adds a finding if the value is outside the range. NaN is always outside.
    void expect(Grade grade, const std::string& what, double value, const std::string& unit, Range range,
                const std::string& reason) {
        if (value >= range.low && value <= range.high) return;
        const std::string low = formatNumber(range.low), high = formatNumber(range.high);
        const std::string expected = std::isinf(range.high)  ? "at least " + low
                                     : std::isinf(range.low) ? "at most " + high
                                     : low == high           ? low
                                                             : low + " to " + high;
        add(grade, what, formatNumber(value) + " " + unit, expected + " " + unit, reason);
    }
    void add(Grade grade, const std::string& what, const std::string& value, const std::string& expected,
             const std::string& reason) {
        list.push_back({grade == refused, what, value, expected, reason});
    }

    std::vector<Finding> list;
};
}  // namespace stylet::modeller
