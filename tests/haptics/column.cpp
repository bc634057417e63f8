#include "tests/haptics/column.h"

#include <cmath>

#include "tests/support/motion.h"
#include "tests/support/phantom.h"

namespace stylet::test {

patient::Package makeColumn(const Layers& layers, double pitch_m) {
    std::vector<std::uint8_t> column;
    for (const auto& [tissue, thickness_m] : layers) {
        column.insert(column.end(), std::size_t(std::lround(thickness_m / pitch_m)), std::uint8_t(tissue));
    }
    patient::Package package;
    package.tissues = tissueDefaults().tissues;
    package.elasticity = tissueDefaults().elasticity;
    package.thresholds = tissueDefaults().thresholds;
    package.label_table = tissueLabels();
    const Grid grid{{int(column.size()), 1, 1}, {pitch_m, 0.08, 0.08}, {0.5 * pitch_m, 0.0, 0.0}};
    package.ct = CtVolume(grid, std::int16_t(-1000));
    package.labels = LabelVolume(grid);
    package.labels.voxels = column;
    return package;
}

patient::Package repeatColumn(const patient::Package& column, int n, double pitch_m) {
    patient::Package package = column;
    Grid grid = column.labels.grid;
    grid.dims = {grid.dims.x, n, n};
    grid.spacing_m = {grid.spacing_m.x, pitch_m, pitch_m};
    grid.origin_m = {grid.origin_m.x, -0.5 * pitch_m * (n - 1), -0.5 * pitch_m * (n - 1)};
    package.ct = CtVolume(grid, std::int16_t(-1000));
    package.labels = LabelVolume(grid);
    for (std::size_t i = 0; i < package.labels.voxels.size(); ++i)
        package.labels.voxels[i] = column.labels.voxels[i % std::size_t(grid.dims.x)];
    return package;
}

void addBreathing(patient::Package& package, double travel_m) {
    package.motion = makeShift(travel_m);
    package.signal = {4.0, 1.0};
}

void Hand::to(const Vec3& tip_m) {
    haptics::NeedleEvents step;
    last = haptics::stepNeedle(state, settings, {patient, breath}, {tip_m, axis}, step, incisions);
    events.insert(events.end(), step.list.begin(), step.list.begin() + step.count);
}

void Hand::sweep(double x_m, double step_m) {
    const Vec3 from = state.tip_deformed_m;
    const int steps = std::max(1, int(std::ceil(std::fabs(x_m - from.x) / step_m)));
    for (int i = 1; i <= steps; ++i)
        to({from.x + (x_m - from.x) * i / steps, from.y, from.z});
}

std::vector<haptics::NeedleEvent> Hand::eventsOf(haptics::NeedleEventKind kind) const {
    std::vector<haptics::NeedleEvent> list;
    for (const haptics::NeedleEvent& e : events) {
        if (e.kind == kind) list.push_back(e);
    }
    return list;
}

}  // namespace stylet::test
