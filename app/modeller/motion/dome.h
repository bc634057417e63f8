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
    // The point on the dome over a column.
    Vec3 point(int x, int y) const {
        return {grid.origin_m.x + x * grid.spacing_m.x, grid.origin_m.y + y * grid.spacing_m.y,
                double(at(x, y))};
    }
    // Bilinear between columns; NaN if one of the four has no height.
    double heightAt(double x_m, double y_m) const;
};
DomeMap findDome(const FloatVolume& hu);

// The columns used to assess a fit. They form one connected sheet in every phase and lie at most 20 mm below
// its top in phase `reference`.
struct DomeColumns {
    std::vector<std::array<int, 2>> columns;
    int slice_y = 0;  // the coronal slice through the top
};
// Throws ImportError if no dome is visible.
DomeColumns selectDomeColumns(const std::vector<DomeMap>&, std::size_t reference);

// Mean HU of the lung for each phase. Inspired lung is less dense. Only columns at least 10 mm away from the
// given dome columns are used, so that the surrogate does not depend on them.
std::vector<double> lungDensityOutsideDome(const std::vector<Phase>&, const DomeColumns&);

}  // namespace stylet::modeller
