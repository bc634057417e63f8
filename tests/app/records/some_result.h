// An attempt result. One metric value is infinite and one is NaN.
#pragma once

#include <cmath>
#include <limits>

#include "app/records/store.h"

namespace stylet::test {

inline records::AttemptResult someResult() {
    return {true,
            87.5,
            12345,
            {{"clearance", "least clearance", "mm", std::numeric_limits<double>::infinity(), 10.0, 12.0},
             {"angle", "duct angle", "deg", std::nan(""), 0.0, 8.0}}};
}

}  // namespace stylet::test
