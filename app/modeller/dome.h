// The diaphragm's dome in a chest CT, and a surrogate of the breath that does not look at it.
#pragma once

#include <array>
#include <vector>

#include "app/modeller/phases.h"

namespace stylet::modeller {

// The height of the diaphragm over each column (x, y), from the feet the first step from tissue to lung; NaN
// where there is none.
struct DomeMap {
    patient::Grid grid;
    std::vector<float> z_m;
    float at(int x, int y) const { return z_m[std::size_t(y) * std::size_t(grid.dims.x) + std::size_t(x)]; }
    // Linear between columns; NaN where one of the four has none.
    double heightAt(double x_m, double y_m) const;
};
DomeMap domeOf(const FloatVolume& hu);

// The columns a fit is judged by: one sheet in every phase, within 20 mm below its top in `reference`.
struct DomeColumns {
    std::vector<std::array<int, 2>> columns;
    int slice_y = 0;  // the coronal slice through the top
};
// Throws ImportError where no dome is seen.
DomeColumns judgedColumns(const std::vector<DomeMap>&, std::size_t reference);

// Mean HU of the lung in columns at least 10 mm away from those judged: inspired lung is thinner.
std::vector<double> lungDensityAway(const std::vector<Phase>&, const DomeColumns&);

}  // namespace stylet::modeller
