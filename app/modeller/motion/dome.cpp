#include "app/modeller/motion/dome.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace stylet::modeller {

namespace {

constexpr float kBorder_hu = -300.0f;  // halfway between lung and liver
constexpr float kLung_hu = -500.0f;
constexpr double kLungAbove_m = 0.006;  // depth of lung required above the dome
constexpr double kMaxJump_m = 0.004;    // largest height difference between neighbouring columns of one sheet
constexpr double kBelowTop_m = 0.020, kAway_m = 0.010;
constexpr std::size_t kMinColumns = 100;

float domeHeightAt(const FloatVolume& hu, int x, int y) {
    const Grid& g = hu.grid;
    const int above = std::max(1, int(kLungAbove_m / g.spacing_m.z));
    for (int z = 1; z + above < g.dims.z; ++z) {
        if (!(hu[{x, y, z}] < kBorder_hu)) continue;
        const float below_hu = hu[{x, y, z - 1}];
        // The column starts in lung at its lower end, so the step from tissue to lung is outside the image.
        if (below_hu < kBorder_hu) return std::numeric_limits<float>::quiet_NaN();
        float mean_hu = 0.0f;
        for (int k = 0; k < above; ++k)
            mean_hu += hu[{x, y, z + k}] / float(above);
        if (mean_hu > kLung_hu) continue;
        const float share = (kBorder_hu - below_hu) / (hu[{x, y, z}] - below_hu);
        return float(g.origin_m.z + (z - 1 + double(share)) * g.spacing_m.z);
    }
    return std::numeric_limits<float>::quiet_NaN();
}

// Returns all columns that are connected to the column (x, y). Two neighbouring columns are connected if
// their diaphragm heights differ by less than kMaxJump_m in every phase. Sets `visited` for all columns
// returned.
std::vector<std::array<int, 2>> growSheet(const std::vector<DomeMap>& maps, int x, int y,
                                          std::vector<unsigned char>& visited) {
    const Grid& g = maps.front().grid;
    const auto index = [&](int i, int k) { return std::size_t(k) * std::size_t(g.dims.x) + std::size_t(i); };
    std::vector<std::array<int, 2>> sheet{{x, y}};
    visited[index(x, y)] = 1;
    for (std::size_t next = 0; next < sheet.size(); ++next) {
        const auto [i, k] = sheet[next];
        constexpr int kSteps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
        for (const auto& step : kSteps) {
            const int a = i + step[0], b = k + step[1];
            if (a < 0 || b < 0 || a >= g.dims.x || b >= g.dims.y || visited[index(a, b)]) continue;
            // A column without a dome has the height NaN. The comparison is then false, so the column is not
            // joined.
            const bool joined = std::all_of(maps.begin(), maps.end(), [&](const DomeMap& m) {
                return std::fabs(double(m.at(a, b)) - double(m.at(i, k))) < kMaxJump_m;
            });
            if (!joined) continue;
            visited[index(a, b)] = 1;
            sheet.push_back({a, b});
        }
    }
    return sheet;
}

}  // namespace

double DomeMap::heightAt(double x_m, double y_m) const {
    const double x = (x_m - grid.origin_m.x) / grid.spacing_m.x,
                 y = (y_m - grid.origin_m.y) / grid.spacing_m.y;
    const int i = int(std::floor(x)), k = int(std::floor(y));
    if (!(i >= 0 && k >= 0 && i + 1 < grid.dims.x && k + 1 < grid.dims.y))
        return std::numeric_limits<double>::quiet_NaN();
    const double u = x - i, v = y - k;
    return (1.0 - v) * ((1.0 - u) * double(at(i, k)) + u * double(at(i + 1, k))) +
           v * ((1.0 - u) * double(at(i, k + 1)) + u * double(at(i + 1, k + 1)));
}

DomeMap findDome(const FloatVolume& hu) {
    DomeMap map{hu.grid, std::vector<float>(std::size_t(hu.grid.dims.x) * std::size_t(hu.grid.dims.y))};
    parallelFor(processorCount(), hu.grid.dims.y, [&](int y) {
        for (int x = 0; x < hu.grid.dims.x; ++x)
            map.z_m[std::size_t(y) * std::size_t(hu.grid.dims.x) + std::size_t(x)] = domeHeightAt(hu, x, y);
    });
    return map;
}

DomeColumns selectDomeColumns(const std::vector<DomeMap>& maps, std::size_t reference) {
    const Grid& g = maps.front().grid;
    std::vector<unsigned char> visited(maps.front().z_m.size(), 0);
    std::vector<std::array<int, 2>> sheet;
    for (int y = 0; y < g.dims.y; ++y)
        for (int x = 0; x < g.dims.x; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(g.dims.x) + std::size_t(x);
            const bool everywhere = std::all_of(maps.begin(), maps.end(),
                                                [&](const DomeMap& m) { return std::isfinite(m.z_m[i]); });
            if (visited[i] || !everywhere) continue;
            std::vector<std::array<int, 2>> other = growSheet(maps, x, y, visited);
            if (other.size() > sheet.size()) sheet = std::move(other);
        }
    DomeColumns out;
    double top_m = -1e9;
    for (const auto& [x, y] : sheet)
        if (double(maps[reference].at(x, y)) > top_m)
            top_m = double(maps[reference].at(x, y)), out.slice_y = y;
    for (const auto& [x, y] : sheet)
        if (double(maps[reference].at(x, y)) > top_m - kBelowTop_m) out.columns.push_back({x, y});
    if (out.columns.size() < kMinColumns) throw ImportError("the phases show no dome of a diaphragm");
    return out;
}

std::vector<double> lungDensityOutsideDome(const std::vector<Phase>& phases,
                                           const DomeColumns& dome_columns) {
    Grid flat = phases.front().hu.grid;
    flat.dims.z = 1;
    Mask columns(flat);
    for (const auto& [x, y] : dome_columns.columns)
        columns[{x, y, 0}] = 1;
    const FloatVolume distance = distanceTo(columns);
    std::vector<double> means;
    for (const Phase& phase : phases) {
        double sum = 0.0;
        std::size_t count = 0;
        const Grid& g = phase.hu.grid;
        forEachVoxel(g, [&](const Index3& i) {
            const float hu = phase.hu[i];
            if (hu < kBorder_hu && double(distance[{i.x, i.y, 0}]) >= kAway_m) sum += double(hu), ++count;
        });
        if (count < kMinColumns) throw ImportError("no lung is visible beside the dome");
        means.push_back(sum / double(count));
    }
    return means;
}

}  // namespace stylet::modeller
