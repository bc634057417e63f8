#include "app/modeller/segmentation/lungs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/modeller/image/morphology.h"

namespace stylet::modeller {

namespace {

constexpr std::int16_t kAir_hu = -400;  // halfway between lung and soft tissue
// Lung contains at least 5 % tissue, gas none. The noise of a mean over 27 voxels is a few HU.
constexpr float kGas_hu = -955.0f, kMaxLung_hu = -550.0f;
constexpr double kPale_hu = -900.0, kEven_hu = 12.0;  // upper limits of the mean and deviation of gas
constexpr double kLungRim_m = 0.0025;                 // rim in which an edge's blur hides the kind of air
constexpr double kLungVessel_m = 0.004;               // radius of the vessels included in the lung
constexpr double kMinLung_ml = 25.0;
constexpr std::uint8_t kLung = 1, kGas = 2;

struct Cores {
    Mask lung, gas;
};

// Separates lung from gas. Lungs are large, or continue above the section. Vessels and airways make them
// uneven, while gas is uniform whatever its HU in this scan. Pieces too small to decide are neither.
Cores classifyCores(const Mask& core, const FloatVolume& mean) {
    const Grid& g = core.grid;
    const Components p = findComponents(core);
    std::vector<double> sum(p.size.size(), 0.0), square(p.size.size(), 0.0);
    for (std::size_t i = 0; i < mean.voxels.size(); ++i) {
        const auto n = std::size_t(p.number.voxels[i]);
        const double hu = double(mean.voxels[i]);
        sum[n] += hu, square[n] += hu * hu;
    }
    std::vector<bool> at_top(p.size.size(), false);
    for (std::size_t i = g.offset({0, 0, std::max(g.dims.z - 2, 0)}); i < p.number.voxels.size(); ++i)
        at_top[std::size_t(p.number.voxels[i])] = true;
    enum class Kind : std::uint8_t { none, lung, gas };
    std::vector<Kind> kind(p.size.size(), Kind::none);
    const double each_ml = voxelVolume_ml(g), largest = double(p.size[std::size_t(p.largest())]);
    for (std::size_t n = 1; n < kind.size(); ++n) {
        const double count = double(p.size[n]), middle = sum[n] / count;
        if (count * each_ml < kMinLung_ml) continue;
        if (middle < kPale_hu && square[n] / count - middle * middle < kEven_hu * kEven_hu)
            kind[n] = Kind::gas;
        else if (at_top[n] || count > 0.2 * largest)
            kind[n] = Kind::lung;
    }
    return {componentsWhere(p, [&](std::size_t n) { return kind[n] == Kind::lung; }),
            componentsWhere(p, [&](std::size_t n) { return kind[n] == Kind::gas; })};
}

// Classifies air as lung or gas. Deep inside, the density decides; elsewhere, the nearer core decides.
LabelVolume classifyAir(const CtVolume& ct, const Mask& body) {
    const double step_m = std::max({ct.grid.spacing_m.x, ct.grid.spacing_m.y, ct.grid.spacing_m.z});
    Mask air = eroded(body, 1.01 * step_m);  // skin is blurred with the air around it
    for (std::size_t i = 0; i < air.voxels.size(); ++i)
        air.voxels[i] = air.voxels[i] && ct.voxels[i] < kAir_hu;
    const Mask inner = eroded(air, std::max(kLungRim_m, step_m));
    Mask lung, gas;
    {
        const FloatVolume mean = boxMean(toFloat(ct), 1);
        const Mask core = maskWhere(ct.grid, [&](std::size_t i) {
            return inner.voxels[i] && mean.voxels[i] > kGas_hu && mean.voxels[i] < kMaxLung_hu;
        });
        Cores cores = classifyCores(core, mean);
        lung = std::move(cores.lung), gas = std::move(cores.gas);
        for (std::size_t i = 0; i < inner.voxels.size(); ++i)
            gas.voxels[i] = gas.voxels[i] || (inner.voxels[i] && mean.voxels[i] <= kGas_hu);
    }
    removeSmallComponents(gas, 0.2);
    LabelVolume seeds(ct.grid);
    for (std::size_t i = 0; i < seeds.voxels.size(); ++i)
        seeds.voxels[i] = lung.voxels[i] ? kLung : gas.voxels[i] ? kGas : std::uint8_t{0};
    LabelVolume kind = growSeeds(seeds, air);
    // Air without a core: lung if it is next to the lung, otherwise a bubble of gas.
    const Mask beside = dilated(withLabel(kind, kLung), std::max(0.003, step_m));
    for (std::size_t i = 0; i < kind.voxels.size(); ++i)
        if (air.voxels[i] && !kind.voxels[i]) kind.voxels[i] = beside.voxels[i] ? kLung : kGas;
    return kind;
}

double meanX(const Mask& m) {
    const Grid& g = m.grid;
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < m.voxels.size(); ++i)
        if (m.voxels[i]) sum += double(i % std::size_t(g.dims.x)), count += 1.0;
    return count > 0.0 ? sum / count : 0.5 * g.dims.x;
}

// Finds the smallest erosion that leaves two large pieces on different sides, and returns these pieces.
bool separateLungs(const Mask& lung, double middle_x, Mask& right, Mask& left) {
    constexpr double kMaxErosion_m = 0.012, kShare = 0.1;
    const double step_m = std::max(0.002, lung.grid.spacing_m.x), total = double(countVoxels(lung));
    for (double r = 0.0; r <= kMaxErosion_m; r += step_m) {
        const Components p = findComponents(r > 0.0 ? eroded(lung, r) : lung);
        const int first = p.largest();
        if (first == 0) return false;
        int second = 0;
        for (int n = 1; n <= p.count(); ++n)
            if (n != first && (second == 0 || p.size[std::size_t(n)] > p.size[std::size_t(second)]))
                second = n;
        if (second == 0 || double(p.size[std::size_t(second)]) < kShare * total) continue;
        Mask a = componentMask(p, first), b = componentMask(p, second);
        const double xa = meanX(a), xb = meanX(b);
        if ((xa > middle_x) == (xb > middle_x) && std::fabs(xa - xb) < 0.15 * lung.grid.dims.x) continue;
        right = xa > xb ? a : b;
        left = xa > xb ? b : a;
        return true;
    }
    return false;
}

void splitSides(const Mask& lung, double middle_x, Lungs& out) {
    Mask right(lung.grid), left(lung.grid);
    if (!separateLungs(lung, middle_x, right, left)) {
        if (countVoxels(lung) == 0) {
            out.notes.push_back("no lung in the section");
            return;
        }
        const bool is_right = meanX(lung) > middle_x;
        (is_right ? out.right : out.left) = lung;
        out.notes.push_back(is_right ? "only the right lung was found" : "only the left lung was found");
        return;
    }
    LabelVolume seeds(lung.grid);
    for (std::size_t i = 0; i < seeds.voxels.size(); ++i)
        seeds.voxels[i] = right.voxels[i] ? 1 : left.voxels[i] ? 2 : 0;
    const LabelVolume side = growSeeds(seeds, lung);
    out.right = withLabel(side, 1), out.left = withLabel(side, 2);
    for (std::size_t i = 0; i < lung.voxels.size(); ++i)
        if (lung.voxels[i] && side.voxels[i] == 0)  // a recess without a face connection
            (double(i % std::size_t(lung.grid.dims.x)) > middle_x ? out.right : out.left).voxels[i] = 1;
}

Mask fillVessels(const Mask& lung, const Mask& body, const Mask& gas, const Mask& other) {
    Mask full = closed(lung, kLungVessel_m);
    for (std::size_t i = 0; i < full.voxels.size(); ++i)
        full.voxels[i] =
            lung.voxels[i] || (full.voxels[i] && body.voxels[i] && !gas.voxels[i] && !other.voxels[i]);
    fillCavities(full);
    return subtract(full, gas);
}

// Separates airways from bowel gas. An airway has lung below it or leaves the section at the top with the
// trachea. Gas in the abdomen has no lung below.
Mask findAirways(const Mask& gas, const Mask& lungs) {
    constexpr double kShare = 0.25;
    const Grid& g = gas.grid;
    const Components p = findComponents(gas);
    std::vector<std::size_t> above_lung(p.size.size(), 0);
    std::vector<bool> at_top(p.size.size(), false);
    for (int y = 0; y < g.dims.y; ++y)
        for (int x = 0; x < g.dims.x; ++x) {
            bool lung_below = false;
            for (int z = 0; z < g.dims.z; ++z) {
                const Index3 i{x, y, z};
                lung_below = lung_below || lungs[i];
                const auto n = std::size_t(p.number[i]);
                if (n == 0) continue;
                above_lung[n] += lung_below;
                if (z == g.dims.z - 1) at_top[n] = true;
            }
        }
    const bool chest = countVoxels(lungs) > 0;
    return componentsWhere(p, [&](std::size_t n) {
        return chest && (at_top[n] || double(above_lung[n]) > kShare * double(p.size[n]));
    });
}

}  // namespace

DomeMap lungBase(const Mask& lung, const Mask& body) {
    constexpr double kMinHeight_m = 0.008;  // thinner is a rim, not a column of lung
    const Grid& g = lung.grid;
    DomeMap base{g, std::vector<float>(std::size_t(g.dims.x) * std::size_t(g.dims.y),
                                       std::numeric_limits<float>::quiet_NaN())};
    for (int y = 0; y < g.dims.y; ++y)
        for (int x = 0; x < g.dims.x; ++x) {
            int low = 0;
            while (low < g.dims.z && !lung[{x, y, low}])
                ++low;
            if (low == 0 || low == g.dims.z || !body[{x, y, low - 1}]) continue;
            int end = low;
            while (end < g.dims.z && lung[{x, y, end}])
                ++end;
            if (end < g.dims.z && (end - low) * g.spacing_m.z < kMinHeight_m) continue;
            base.z_m[std::size_t(y) * std::size_t(g.dims.x) + std::size_t(x)] =
                float(g.centre({x, y, low}).z - 0.5 * g.spacing_m.z);
        }
    return base;
}

Lungs findLungs(const CtVolume& ct, const Mask& body) {
    const Grid& g = ct.grid;
    Lungs out{Mask(g), Mask(g), Mask(g), Mask(g), {}, {}, {}};
    const LabelVolume kind = classifyAir(ct, body);
    const Mask lung = withLabel(kind, kLung);
    out.gas = withLabel(kind, kGas);
    splitSides(lung, meanX(body), out);
    out.airways = findAirways(out.gas, lung);
    out.right = fillVessels(out.right, body, out.gas, out.left);
    out.left = fillVessels(out.left, body, out.gas, out.right);
    out.gas = subtract(out.gas, out.airways);
    out.base_right = lungBase(out.right, body);
    out.base_left = lungBase(out.left, body);
    return out;
}

}  // namespace stylet::modeller
