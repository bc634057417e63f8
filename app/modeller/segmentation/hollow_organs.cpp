// Finds stomach and colon by their gas. The position decides which organ the gas belongs to. The wall, and
// the fluid behind a fluid level, are added.
#include <algorithm>
#include <cmath>

#include "app/modeller/segmentation/morphology.h"
#include "app/modeller/segmentation/organ_scene.h"

namespace stylet::modeller {

namespace {

constexpr double kGutWall_m = 0.003;
constexpr double kMinGas_ml = 0.5;  // smaller bubbles are ignored

struct GasPiece {
    double volume_ml = 0.0;
    double position_score = 0.0;  // mean of stomachPositionScore()
};

// Height of the top of the left dome. The stomach lies below it.
double leftDomeHeight(const OrganScene& s) {
    double top = -1e9;
    for (const float z : s.in.lungs.base_left.z_m)
        if (std::isfinite(z)) top = std::max(top, double(z));
    return top > -1e8 ? top : s.grid.centre(s.grid.dims - 1).z;
}

// Returns how well a position matches that of the stomach, 0 to 1: below the left dome, left of the spine and
// well in front of it, and not at the side wall, where the colon turns.
double stomachPositionScore(const Vec3& from_canal, double below_dome_m) {
    constexpr double kX_m = -0.040, kY_m = 0.100, kBelow_m = 0.065;
    constexpr double kReachX_m = 0.040, kReachY_m = 0.060, kReachZ_m = 0.060;
    const double x = (from_canal.x - kX_m) / kReachX_m, y = (from_canal.y - kY_m) / kReachY_m,
                 z = (below_dome_m - kBelow_m) / kReachZ_m;
    return std::exp(-(x * x + y * y + z * z));
}

std::vector<GasPiece> measureGas(const OrganScene& s, const Components& p, double dome_m) {
    std::vector<GasPiece> out(p.size.size());
    forEachVoxel(s.grid, [&](const Index3& i) {
        if (const auto n = std::size_t(p.number[i]); n > 0)
            out[n].position_score += stomachPositionScore(s.fromCanal(i), dome_m - s.grid.centre(i).z);
    });
    for (std::size_t n = 1; n < out.size(); ++n) {
        out[n].position_score /= double(p.size[n]);
        out[n].volume_ml = double(p.size[n]) * voxelVolume_ml(s.grid);
    }
    return out;
}

// Finds fluid levels. Fluid lies behind its gas, and the level between them is flat: in each slice, the gas
// within a few millimetres of its hindmost voxel is nearly as wide as its maximum width. `below` contains
// the voxels behind the level, and `y` the foremost level.
struct FluidLevels {
    Mask below;
    int y = -1;
};

FluidLevels findFluidLevels(const OrganScene& s, const Mask& gas) {
    constexpr double kFlat = 0.65, kMinWidth_m = 0.010, kRough_m = 0.003;
    constexpr int kBlur = 3;  // blurred voxels behind the level, neither gas nor fluid
    const Grid& g = s.grid;
    const int rough = std::max(1, int(kRough_m / g.spacing_m.y));
    FluidLevels out{Mask(g)};
    const Components p = findComponents(gas);
    const std::size_t rows = std::size_t(rough) + 1;
    std::vector<int> hindmost(p.size.size()), low(p.size.size()), high(p.size.size()), level(p.size.size());
    std::vector<int> width(p.size.size() * rows);
    for (int z = 0; z < g.dims.z; ++z) {
        std::fill(hindmost.begin(), hindmost.end(), g.dims.y);
        std::fill(width.begin(), width.end(), 0);
        std::fill(low.begin(), low.end(), g.dims.x);
        std::fill(high.begin(), high.end(), -1);
        std::fill(level.begin(), level.end(), -1);
        const auto each = [&](auto&& f) {
            for (int y = 0; y < g.dims.y; ++y)
                for (int x = 0; x < g.dims.x; ++x)
                    if (const auto n = std::size_t(p.number[{x, y, z}]); n > 0) f(n, x, y);
        };
        each([&](std::size_t n, int x, int y) {
            hindmost[n] = std::min(hindmost[n], y);
            low[n] = std::min(low[n], x);
            high[n] = std::max(high[n], x);
        });
        each([&](std::size_t n, int, int y) {
            if (y <= hindmost[n] + rough) ++width[n * rows + std::size_t(y - hindmost[n])];
        });
        for (std::size_t n = 1; n < p.size.size(); ++n)
            for (int k = rough; k >= 0; --k) {
                const int wide = width[n * rows + std::size_t(k)];
                if (wide * g.spacing_m.x >= kMinWidth_m && wide >= kFlat * (high[n] - low[n] + 1))
                    level[n] = hindmost[n] + k;
            }
        each([&](std::size_t n, int x, int y) {
            if (y > level[n]) return;
            for (int back = 1; back <= kBlur && y - back >= 0; ++back)
                out.below[{x, y - back, z}] = s.free[{x, y - back, z}];
            out.y = std::max(out.y, level[n]);
        });
    }
    return out;
}

// Returns the fluid behind the level of a piece of gas. Fluid has the HU of dark soft tissue and is thicker
// than a loop of the small bowel.
Mask findFluid(const OrganScene& s, const FloatVolume& mixed, const Mask& gas, double reach_m,
               double high_hu) {
    constexpr double kFat_hu = -30.0, kLoop_m = 0.010;
    const FluidLevels levels = findFluidLevels(s, gas);
    if (levels.y < 0) return Mask(s.grid);
    Mask soft = inRange(mixed, s.free, kFat_hu, high_hu);
    forEachVoxel(VoxelBox{{0, levels.y + 1, 0}, s.grid.dims - 1}, [&](const Index3& i) { soft[i] = 0; });
    soft = unite(opened(soft, kLoop_m), levels.below);
    return opened(growWithin(levels.below, soft, reach_m), kGutWall_m);
}

// Adds the wall around gas and fluid. The blurred surface of the gas counts as wall.
Mask addWall(const OrganScene& s, const Mask& gas, const Mask& fluid) {
    constexpr double kFat_hu = -30.0, kMaxWall_hu = 400.0;
    const Mask rim = intersect(dilated(gas, std::max(kGutWall_m, 1.8 * s.grid.spacing_m.x)), s.free);
    const Mask wall =
        intersect(dilated(unite(gas, fluid), kGutWall_m), inRange(s.smooth_hu, s.free, kFat_hu, kMaxWall_hu));
    return subtract(unite(unite(rim, wall), fluid), intersect(s.in.lungs.gas, s.free_wide));
}

// The piece of gas that is the stomach, and the lead of its score over the second best piece.
struct StomachChoice {
    std::size_t piece = 0;
    double margin = 0.0;
};

StomachChoice chooseStomach(const std::vector<GasPiece>& pieces) {
    constexpr double kMinScore = 0.15;
    StomachChoice c;
    double best = kMinScore, next = 0.0;
    for (std::size_t n = 1; n < pieces.size(); ++n) {
        if (pieces[n].volume_ml < kMinGas_ml) continue;
        const double score = std::cbrt(pieces[n].volume_ml) * pieces[n].position_score;
        if (score > best)
            next = best, best = score, c.piece = n;
        else
            next = std::max(next, score);
    }
    c.margin = (best - next) / best;
    return c;
}

// Marks the pieces of gas that lie directly above this fluid: bubbles in the same stomach.
std::vector<bool> findOverFluid(const OrganScene& s, const Components& p, const Mask& gas,
                                const Mask& fluid) {
    constexpr double kShare = 0.3;
    const Mask below = findFluidLevels(s, gas).below, pool = dilated(fluid, 0.003);
    std::vector<double> all(p.size.size(), 0.0), in = all;
    forEachVoxel(VoxelBox{Index3(0), s.grid.dims - Index3(1, 2, 1)}, [&](const Index3& i) {
        const auto n = std::size_t(p.number[i + Index3(0, 1, 0)]);
        if (n == 0 || !below[i]) return;
        all[n] += 1.0;
        in[n] += pool[i];
    });
    std::vector<bool> out(p.size.size(), false);
    for (std::size_t n = 1; n < out.size(); ++n)
        out[n] = all[n] > 0.0 && in[n] > kShare * all[n];
    return out;
}

}  // namespace

std::vector<FoundOrgan> findHollowOrgans(const OrganScene& s, double organs_hu) {
    constexpr double kStomachReach_m = 0.060, kColonReach_m = 0.030, kBelowOrgans_hu = 22.0, kMixed_m = 0.003;
    const Mask gas = intersect(s.in.lungs.gas, s.free_wide);
    const Components p = findComponents(gas);
    const std::vector<GasPiece> pieces = measureGas(s, p, leftDomeHeight(s));
    const StomachChoice choice = chooseStomach(pieces);
    const double dark_hu = organs_hu - kBelowOrgans_hu;
    // Chyme and stool are mixtures from fat to soft tissue, in patches of a few millimetres.
    const FloatVolume mixed = boxMean(toFloat(s.in.ct), std::max(1, int(kMixed_m / s.grid.spacing_m.x)));
    Mask stomach_gas = componentsWhere(p, [&](std::size_t n) { return n == choice.piece; });
    Mask other_gas = componentsWhere(
        p, [&](std::size_t n) { return n != choice.piece && pieces[n].volume_ml >= kMinGas_ml; });
    FoundOrgan stomach{"stomach and oesophagus", Mask(s.grid), 0.0, ""},
        colon{"colon", Mask(s.grid), 0.0, ""};
    if (choice.piece > 0) {
        Mask fluid = findFluid(s, mixed, stomach_gas, kStomachReach_m, dark_hu);
        const std::vector<bool> joins = findOverFluid(s, p, other_gas, fluid);
        const Mask joined = componentsWhere(p, [&](std::size_t n) { return joins[n]; });
        stomach_gas = unite(stomach_gas, joined), other_gas = subtract(other_gas, joined);
        fluid = findFluid(s, mixed, stomach_gas, kStomachReach_m, dark_hu);
        stomach.mask = subtract(addWall(s, stomach_gas, fluid), other_gas);
        stomach.confidence = std::clamp(0.3 + 0.4 * choice.margin, 0.3, 0.7);
        if (stomach.confidence < 0.5)
            stomach.note = "stomach: other gas lies as near to where it is expected";
    } else {
        stomach.note = "stomach: no gas below the left dome, so it was not looked for";
    }
    if (countVoxels(other_gas) > 0) {
        colon.mask = addWall(s, other_gas, findFluid(s, mixed, other_gas, kColonReach_m, dark_hu));
        colon.mask = subtract(subtract(colon.mask, stomach.mask), gas);
        colon.confidence = 0.4;
        colon.note = "colon: gas of the small bowel is not told apart from it";
    } else {
        colon.note = "colon: no gas that would show it";
    }
    const bool any = countVoxels(gas) > 0;
    return {std::move(stomach), std::move(colon),
            FoundOrgan{"bowel gas", gas, any ? 0.95 : 0.0, any ? "" : "bowel gas: none"}};
}

}  // namespace stylet::modeller
