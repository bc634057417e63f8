#include "app/modeller/import/section.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "app/modeller/image/child_process_linux.h"
#include "app/modeller/import/import_body.h"
#include "app/modeller/import/import_map.h"
#include "base/format.h"
#include "patient/patient.h"

namespace stylet::modeller {

using patient::Label;

namespace {

constexpr double kAirAround_m = 0.008, kMostSide_m = 0.50;

}  // namespace

Grid sectionGrid(const Grid& scan, double low_m, double high_m, double spacing_m) {
    // Uses whole voxels from the scan's first voxel: any two sections of one scan share a lattice and can
    // be compared voxel by voxel.
    const auto whole_m = [&](double m) { return std::ceil(m / spacing_m - 1e-6) * spacing_m; };
    const double rim_m = whole_m(kAirAround_m);
    Vec3 from = scan.origin_m - rim_m, to = scan.centre(scan.dims - 1) + rim_m;
    from.z = scan.origin_m.z + whole_m(std::max(0.0, low_m - scan.origin_m.z));
    to.z = std::min(to.z - rim_m, high_m);
    for (int d = 0; d < 2; ++d)
        if (to[d] - from[d] > kMostSide_m + 2.0 * rim_m)
            throw ImportError(formatted("the scan is %.0f mm wide; %.0f mm is the most this program accepts",
                                        1e3 * (to[d] - from[d]), 1e3 * kMostSide_m));
    const Vec3 steps = glm::floor((to - from) / spacing_m);
    return {Index3(steps) + 1, Vec3(spacing_m), from};
}

CtVolume resampleCt(const CtVolume& in, const Grid& grid) {
    CtVolume out(grid, kOutside_hu);
    forEachSlab(grid.dims.z, [&](int z) {
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x) {
                const Vec3 v = in.grid.toVoxels(grid.centre({x, y, z}));
                const Vec3 last(in.grid.dims - 1);
                if (v.x < -0.5 || v.y < -0.5 || v.z < -0.5) continue;
                if (v.x > last.x + 0.5 || v.y > last.y + 0.5 || v.z > last.z + 0.5) continue;
                const Vec3 c = glm::clamp(v, Vec3(0.0), last);
                const Index3 a = glm::min(Index3(c), glm::max(in.grid.dims - 2, Index3(0)));
                const Vec3 f = c - Vec3(a);
                double sum = 0.0;
                for (int k = 0; k < 8; ++k) {
                    const Index3 step{k & 1, k >> 1 & 1, k >> 2};
                    const double w =
                        (step.x ? f.x : 1.0 - f.x) * (step.y ? f.y : 1.0 - f.y) * (step.z ? f.z : 1.0 - f.z);
                    if (w > 0.0) sum += w * in[a + step];
                }
                out[{x, y, z}] = std::int16_t(std::lround(sum));
            }
    });
    return out;
}

Mask cutToBody(CtVolume& ct, LabelVolume& labels) {
    Mask body = bodyMask(ct);
    const Grid g = ct.grid;
    Index3 low{g.dims.x, g.dims.y, 0}, high{-1, -1, g.dims.z - 1};
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 i{x, y, z};
                if (body[i]) {
                    low = {std::min(low.x, x), std::min(low.y, y), 0};
                    high = {std::max(high.x, x), std::max(high.y, y), high.z};
                } else {
                    ct[i] = kOutside_hu;
                    labels[i] = 0;
                }
            }
    if (high.x < 0) throw ImportError("no body is to be seen in the CT");
    const int rim = int(std::ceil(kAirAround_m / g.spacing_m.x));
    low = glm::max(low - Index3{rim, rim, 0}, Index3(0));
    high = glm::min(high + Index3{rim, rim, 0}, g.dims - 1);
    cropTo(ct, low, high);
    cropTo(labels, low, high);
    cropTo(body, low, high);
    return body;
}

// The spacing in the message includes room for a rounded-up rim.
void checkFits(const Grid& g) {
    const double sides[] = {double(g.dims.x), double(g.dims.y), double(g.dims.z)};
    const double voxels = sides[0] * sides[1] * sides[2];
    const double longest = std::max({sides[0], sides[1], sides[2]});
    if (longest <= kMaxVoxelsASide && voxels <= double(kMaxVoxels)) return;
    const double coarser =
        std::max(longest / (kMaxVoxelsASide - 4), std::cbrt(1.01 * voxels / double(kMaxVoxels)));
    throw ImportError(
        formatted("the package would have %dx%dx%d voxels of %.4g mm; %d a side and %zu Mi in all is "
                  "the most it can have, so %.2f mm is the smallest spacing that fits",
                  g.dims.x, g.dims.y, g.dims.z, 1e3 * g.spacing_m.x, kMaxVoxelsASide, kMaxVoxels >> 20,
                  std::ceil(1e5 * g.spacing_m.x * coarser) / 100.0));
}

Mask maskOf(const LabelVolume& labels, const std::function<bool(const Label&)>& wanted) {
    std::array<std::uint8_t, 256> in{};
    for (const Label& l : targetTable())
        in[l.id] = wanted(l);
    Mask mask(labels.grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        mask.voxels[i] = in[labels.voxels[i]];
    return mask;
}

Mask maskOf(const LabelVolume& labels, std::string_view name) {
    return maskOf(labels, [&](const Label& l) { return l.name == name; });
}

std::size_t paint(LabelVolume& labels, const Mask& where, std::uint8_t id, bool over_all) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < where.voxels.size(); ++i)
        if (where.voxels[i] && (over_all || labels.voxels[i] == 0)) labels.voxels[i] = id, ++count;
    return count;
}

}  // namespace stylet::modeller
