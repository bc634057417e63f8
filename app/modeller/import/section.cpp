#include "app/modeller/import/section.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "app/modeller/image/import_error.h"
#include "app/modeller/import/import_body.h"
#include "app/modeller/import/import_map.h"
#include "patient/patient.h"

namespace stylet::modeller {

using patient::Label;

namespace {

constexpr double kAirAround_m = 0.008, kMaxWidth_m = 0.50;

// Where a voxel of a grid lies along one axis of another grid.
struct AxisSample {
    int low = 0;
    double share = 0.0;   // weight of the voxel low + 1
    bool inside = false;  // in a voxel of the other grid
};

std::vector<AxisSample> placesAlong(int axis, const Grid& grid, const Grid& in) {
    std::vector<AxisSample> places;
    const double last = in.dims[axis] - 1;
    for (int i = 0; i < grid.dims[axis]; ++i) {
        const double v =
            (grid.origin_m[axis] + grid.spacing_m[axis] * i - in.origin_m[axis]) / in.spacing_m[axis];
        const double c = std::clamp(v, 0.0, last);
        const int low = std::min(int(c), std::max(in.dims[axis] - 2, 0));
        places.push_back({low, c - low, v >= -0.5 && v <= last + 0.5});
    }
    return places;
}

// A tilted gantry or a registration to another scan leaves padding at the scan's ends: slices without a body,
// or with a part of it. Returns the first and the last slice that have more than 85 % of the body's area 15
// mm further in. Towards neck and legs this removes slices, too; they are not needed.
std::pair<int, int> completeSlices(const Mask& body) {
    constexpr double kFurtherIn_m = 0.015, kMinShare = 0.85;
    const Grid& g = body.grid;
    std::vector<double> area(std::size_t(g.dims.z), 0.0);
    forEachVoxel(g, [&](const Index3& i) { area[std::size_t(i.z)] += body[i]; });
    const int in = std::max(1, int(std::lround(kFurtherIn_m / g.spacing_m.z)));
    const auto isCut = [&](int z, int further_in) {
        return area[std::size_t(z)] <= kMinShare * area[std::size_t(further_in)];
    };
    int low = 0, high = g.dims.z - 1;
    while (low + in <= high && isCut(low, low + in))
        ++low;
    while (high - in >= low && isCut(high, high - in))
        --high;
    return {low, high};
}

}  // namespace

Grid sectionGrid(const Grid& scan, double low_m, double high_m, double spacing_m,
                 const std::filesystem::path& source) {
    // The grid is aligned to whole voxels from the scan's first voxel. All sections of one scan therefore
    // share a lattice and can be compared voxel by voxel.
    const auto whole_m = [&](double m) { return std::ceil(m / spacing_m - 1e-6) * spacing_m; };
    const double rim_m = whole_m(kAirAround_m);
    Vec3 from = scan.origin_m - rim_m, to = scan.centre(scan.dims - 1) + rim_m;
    from.z = scan.origin_m.z + whole_m(std::max(0.0, low_m - scan.origin_m.z));
    to.z = std::min(to.z - rim_m, high_m);
    for (int d = 0; d < 2; ++d)
        if (to[d] - from[d] > kMaxWidth_m + 2.0 * rim_m)
            throw ImportError(fmt::format(
                "{}: size: the scan is {:.0f} mm wide; {:.0f} mm is the most this program accepts",
                source.string(), 1e3 * (to[d] - from[d]), 1e3 * kMaxWidth_m));
    const Vec3 steps = glm::floor((to - from) / spacing_m);
    return {Index3(steps) + 1, Vec3(spacing_m), from};
}

CtVolume resampleCt(const CtVolume& in, const Grid& grid) {
    CtVolume out(grid, kOutside_hu);
    const std::array<std::vector<AxisSample>, 3> places{
        placesAlong(0, grid, in.grid), placesAlong(1, grid, in.grid), placesAlong(2, grid, in.grid)};
    parallelVoxels(grid, [&](const Index3& i) {
        const AxisSample &x = places[0][std::size_t(i.x)], &y = places[1][std::size_t(i.y)],
                         &z = places[2][std::size_t(i.z)];
        if (!x.inside || !y.inside || !z.inside) return;
        double sum = 0.0;
        for (int k = 0; k < 8; ++k) {
            const Index3 step{k & 1, k >> 1 & 1, k >> 2};
            const double w = (step.x ? x.share : 1.0 - x.share) * (step.y ? y.share : 1.0 - y.share) *
                             (step.z ? z.share : 1.0 - z.share);
            if (w > 0.0) sum += w * in[Index3(x.low, y.low, z.low) + step];
        }
        out[i] = std::int16_t(std::lround(sum));
    });
    return out;
}

Mask cropToBody(CtVolume& ct, LabelVolume& labels, const std::filesystem::path& source,
                std::vector<std::string>& notes) {
    Mask body = bodyMask(ct);
    const Grid& g = body.grid;
    if (boundingBox(body).empty())
        throw ImportError(source.string() + ": voxels: show no body; choose another series");
    const auto [low_z, high_z] = completeSlices(body);
    std::size_t lost = 0;  // labelled voxels of the body
    forEachVoxel(g, [&](const Index3& i) {
        if (body[i] && i.z >= low_z && i.z <= high_z) return;
        lost += body[i] && labels[i] != 0;
        body[i] = 0, ct[i] = kOutside_hu, labels[i] = 0;
    });
    if (low_z > 0 || high_z < g.dims.z - 1)
        notes.push_back(fmt::format(
            "{:.0f} mm at the lower end and {:.0f} mm at the upper end are left out: the image contains "
            "only a part of the body there{}",
            1e3 * g.spacing_m.z * low_z, 1e3 * g.spacing_m.z * (g.dims.z - 1 - high_z),
            lost == 0 ? ""
                      : fmt::format("; with them {:.1f} ml of labels", double(lost) * voxelVolume_ml(g))));
    VoxelBox box = boxAround(body, int(std::ceil(kAirAround_m / g.spacing_m.x)));
    box.low.z = low_z, box.high.z = high_z;
    ct = cropped(ct, box);
    labels = cropped(labels, box);
    return cropped(body, box);
}

double sliceDistance(const Grid& scan) {
    const Vec3 s = scan.spacing_m;
    return std::max({s.x, s.y, s.z});
}

// The spacing in the message leaves room for an air rim that is rounded up to whole voxels.
void checkPackageSize(const Grid& g) {
    const double sides[] = {double(g.dims.x), double(g.dims.y), double(g.dims.z)};
    const double voxels = sides[0] * sides[1] * sides[2];
    const double longest = std::max({sides[0], sides[1], sides[2]});
    if (longest <= kMaxVoxelsPerSide && voxels <= double(kMaxVoxels)) return;
    const double coarser =
        std::max(longest / (kMaxVoxelsPerSide - 4), std::cbrt(1.01 * voxels / double(kMaxVoxels)));
    throw ImportError(
        fmt::format("the package would have {}x{}x{} voxels of {:.4g} mm; {} a side and {} Mi in all is "
                    "the most it can have, so {:.2f} mm is the smallest spacing that fits",
                    g.dims.x, g.dims.y, g.dims.z, 1e3 * g.spacing_m.x, kMaxVoxelsPerSide, kMaxVoxels >> 20,
                    std::ceil(1e5 * g.spacing_m.x * coarser) / 100.0));
}

Mask labelMask(const LabelVolume& labels, const std::vector<Label>& table,
               const std::function<bool(const Label&)>& wanted) {
    std::array<std::uint8_t, 256> in{};
    for (const Label& l : table)
        in[l.id] = wanted(l);
    return maskWhere(labels.grid, [&](std::size_t i) { return in[labels.voxels[i]]; });
}

Mask labelMask(const LabelVolume& labels, const std::function<bool(const Label&)>& wanted) {
    return labelMask(labels, targetTable(), wanted);
}

Mask labelMask(const LabelVolume& labels, std::string_view name) {
    return labelMask(labels, [&](const Label& l) { return l.name == name; });
}

std::size_t paint(LabelVolume& labels, const Mask& where, std::uint8_t id, bool over_all) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < where.voxels.size(); ++i)
        if (where.voxels[i] && (over_all || labels.voxels[i] == 0)) labels.voxels[i] = id, ++count;
    return count;
}

}  // namespace stylet::modeller
