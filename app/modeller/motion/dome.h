// The diaphragm's dome in a chest CT, and a breathing surrogate that does not depend on the dome.
#pragma once

#include <array>
#include <vector>

#include "app/modeller/motion/phases.h"

namespace stylet::modeller {

// Height of the diaphragm over each column (x, y): the first step from tissue to lung, searching from the
// feet. NaN if there is none.
struct DomeMap {
    Grid grid;
    std::vector<float> z_m;
    float at(int x, int y) const { return z_m[std::size_t(y) * std::size_t(grid.dims.x) + std::size_t(x)]; }
    // Bilinear between columns; NaN if one of the four has no height.
    double heightAt(double x_m, double y_m) const;
};
DomeMap domeOf(const FloatVolume& hu);

// The columns used to assess a fit: one connected sheet in every phase, within 20 mm below its top in
// `reference`.
struct DomeColumns {
    std::vector<std::array<int, 2>> columns;
    int slice_y = 0;  // the coronal slice through the top
};
// Throws ImportError if no dome is visible.
DomeColumns judgedColumns(const std::vector<DomeMap>&, std::size_t reference);

// Mean HU of the lung, per phase, in columns at least 10 mm from the judged ones. Inspired lung is less
// dense.
std::vector<double> lungDensityAway(const std::vector<Phase>&, const DomeColumns&);

}  // namespace stylet::modeller
