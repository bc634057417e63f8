// The tints that stand for tissues behind a curve.
#pragma once

#include "app/report/canvas.h"
#include "patient/tissue.h"

namespace stylet::report {

constexpr Colour bandColour(patient::Tissue tissue) {
    using patient::Tissue;
    switch (tissue) {
        case Tissue::air:
            return {0.88, 0.93, 0.97};
        case Tissue::skin:
            return {0.96, 0.84, 0.76};
        case Tissue::soft:
            return {0.99, 0.95, 0.80};
        case Tissue::bone:
            return {0.90, 0.88, 0.84};
        case Tissue::fascia:
            return {0.86, 0.84, 0.95};
        case Tissue::liver:
            return {0.95, 0.83, 0.81};
        case Tissue::vessel:
            return {0.80, 0.86, 0.97};
        case Tissue::duct:
            return {0.82, 0.93, 0.80};
    }
    return {1, 1, 1};
}

}  // namespace stylet::report
