// Stomach and colon, found by their gas. The position decides which organ the gas belongs to. Fluid below a
// fluid level and the wall are added.
#include <algorithm>
#include <cmath>

#include "app/modeller/segmentation/morphology.h"
#include "app/modeller/segmentation/organ_scene.h"

namespace stylet::modeller {

namespace {

constexpr double kGutWall_m = 0.003;
constexpr double kLeastGas_ml = 0.5;  // smaller bubbles are ignored

struct GasPiece {
    double volume_ml = 0.0;
    double place = 0.0;  // mean of stomachPlace()
};

// Height of the top of the left dome. The stomach lies below it.
double leftDome(const OrganScene& s) {
    double top = -1e9;
    for (const float z : s.in.lungs.base_left.z_m)
        if (std::isfinite(z)) top = std::max(top, double(z));
    return top > -1e8 ? top : s.grid.centre(s.grid.dims - 1).z;
}

// How well a position matches the stomach's, 0 to 1: below the left dome, left of the spine and well in
// front of it, and not at the side wall, where the colon turns.
double stomachPlace(const Vec3& from_canal, double below_dome_m) {
    constexpr double kX_m = -0.040, kY_m = 0.100, kBelow_m = 0.065;
    constexpr double kReachX_m = 0.040, kReachY_m = 0.060, kReachZ_m = 0.060;
    const double x = (from_canal.x - kX_m) / kReachX_m, y = (from_canal.y - kY_m) / kReachY_m,
                 z = (below_dome_m - kBelow_m) / kReachZ_m;
    return std::exp(-(x * x + y * y + z * z));
}

std::vector<GasPiece> measuredGas(const OrganScene& s, const Pieces& p, double dome_m) {
    std::vector<GasPiece> out(p.size.size());
    for (int z = 0; z < s.grid.dims.z; ++z)
        for (int y = 0; y < s.grid.dims.y; ++y)
            for (int x = 0; x < s.grid.dims.x; ++x)
                if (const auto n = std::size_t(p.number[{x, y, z}]); n > 0)
                    out[n].place += stomachPlace(s.fromCanal({x, y, z}), dome_m - s.grid.centre({x, y, z}).z);
    for (std::size_t n = 1; n < out.size(); ++n) {
        out[n].place /= double(p.size[n]);
        out[n].volume_ml = double(p.size[n]) * voxelVolume_ml(s.grid);
    }
    return out;
}

// Finds fluid levels. Fluid lies behind its gas, and the level between them is flat: in each slice, the gas
// within a few millimetres of its hindmost voxel is nearly as wide as its maximum width. `below` contains
// the voxels behind the level, and `y` the foremost level.
struct Levels {
    Mask below;
    int y = -1;
};

Levels levelsOf(const OrganScene& s, const Mask& gas) {
    constexpr double kFlat = 0.65, kLeast_m = 0.010, kRough_m = 0.003;
    constexpr int kBlur = 3;  // blurred voxels behind the level, neither gas nor fluid
    const Grid& g = s.grid;
    const int rough = std::max(1, int(kRough_m / g.spacing_m.y));
    Levels out{Mask(g)};
    const Pieces p = piecesOf(gas);
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
                if (wide * g.spacing_m.x >= kLeast_m && wide >= kFlat * (high[n] - low[n] + 1))
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

// The fluid behind a gas's level, where it is soft, dark and thicker than a loop of the small bowel.
Mask fluidOf(const OrganScene& s, const FloatVolume& mixed, const Mask& gas, double reach_m, double high_hu) {
    constexpr double kFat_hu = -30.0, kLoop_m = 0.010;
    const Levels levels = levelsOf(s, gas);
    if (levels.y < 0) return Mask(s.grid);
    Mask soft = inRange(mixed, s.free, kFat_hu, high_hu);
    for (int z = 0; z < s.grid.dims.z; ++z)
        for (int y = levels.y + 1; y < s.grid.dims.y; ++y)
            for (int x = 0; x < s.grid.dims.x; ++x)
                soft[{x, y, z}] = 0;
    soft = either(opened(soft, kLoop_m), levels.below);
    return opened(regrown(levels.below, soft, reach_m), kGutWall_m);
}

// Adds the wall around gas and fluid. The blurred surface of the gas counts as wall.
Mask withWall(const OrganScene& s, const Mask& gas, const Mask& fluid) {
    constexpr double kFat_hu = -30.0, kMost_hu = 400.0;
    const Mask rim = both(dilated(gas, std::max(kGutWall_m, 1.8 * s.grid.spacing_m.x)), s.free);
    const Mask wall =
        both(dilated(either(gas, fluid), kGutWall_m), inRange(s.calm, s.free, kFat_hu, kMost_hu));
    return without(either(either(rim, wall), fluid), both(s.in.lungs.gas, s.free_wide));
}

// The stomach's piece, and the lead of its score over the second best.
struct Choice {
    std::size_t piece = 0;
    double lead = 0.0;
};

Choice stomachAmong(const std::vector<GasPiece>& pieces) {
    constexpr double kLeast = 0.15;
    Choice c;
    double best = kLeast, next = 0.0;
    for (std::size_t n = 1; n < pieces.size(); ++n) {
        if (pieces[n].volume_ml < kLeastGas_ml) continue;
        const double score = std::cbrt(pieces[n].volume_ml) * pieces[n].place;
        if (score > best)
            next = best, best = score, c.piece = n;
        else
            next = std::max(next, score);
    }
    c.lead = (best - next) / best;
    return c;
}

// Marks the pieces of gas whose level lies on this fluid: several bubbles of one stomach.
std::vector<bool> over(const OrganScene& s, const Pieces& p, const Mask& gas, const Mask& fluid) {
    constexpr double kShare = 0.3;
    const Mask below = levelsOf(s, gas).below, pool = dilated(fluid, 0.003);
    std::vector<double> all(p.size.size(), 0.0), in = all;
    for (int z = 0; z < s.grid.dims.z; ++z)
        for (int y = 0; y + 1 < s.grid.dims.y; ++y)
            for (int x = 0; x < s.grid.dims.x; ++x) {
                const auto n = std::size_t(p.number[{x, y + 1, z}]);
                if (n == 0 || !below[{x, y, z}]) continue;
                all[n] += 1.0;
                in[n] += pool[{x, y, z}];
            }
    std::vector<bool> out(p.size.size(), false);
    for (std::size_t n = 1; n < out.size(); ++n)
        out[n] = all[n] > 0.0 && in[n] > kShare * all[n];
    return out;
}

}  // namespace

std::vector<FoundOrgan> findHollow(const OrganScene& s) {
    constexpr double kStomachReach_m = 0.060, kColonReach_m = 0.030, kBelowLiver_hu = 22.0, kMixed_m = 0.003;
    const Mask gas = both(s.in.lungs.gas, s.free_wide);
    const Pieces p = piecesOf(gas);
    const std::vector<GasPiece> pieces = measuredGas(s, p, leftDome(s));
    const Choice choice = stomachAmong(pieces);
    const double dark_hu = s.parenchyma_hu - kBelowLiver_hu;
    // Chyme and stool are mixtures from fat to soft tissue, in patches of a few millimetres.
    FloatVolume mixed(s.grid);
    for (std::size_t i = 0; i < mixed.voxels.size(); ++i)
        mixed.voxels[i] = float(s.in.ct.voxels[i]);
    mixed = boxMean(mixed, std::max(1, int(kMixed_m / s.grid.spacing_m.x)));
    Mask stomach_gas(s.grid), other_gas(s.grid);
    for (std::size_t i = 0; i < gas.voxels.size(); ++i) {
        const auto n = std::size_t(p.number.voxels[i]);
        stomach_gas.voxels[i] = n > 0 && n == choice.piece;
        other_gas.voxels[i] = n > 0 && n != choice.piece && pieces[n].volume_ml >= kLeastGas_ml;
    }
    FoundOrgan stomach{"stomach and oesophagus", Mask(s.grid), 0.0, ""},
        colon{"colon", Mask(s.grid), 0.0, ""};
    if (choice.piece > 0) {
        Mask fluid = fluidOf(s, mixed, stomach_gas, kStomachReach_m, dark_hu);
        const std::vector<bool> joins = over(s, p, other_gas, fluid);
        for (std::size_t i = 0; i < gas.voxels.size(); ++i)
            if (joins[std::size_t(p.number.voxels[i])]) stomach_gas.voxels[i] = 1, other_gas.voxels[i] = 0;
        fluid = fluidOf(s, mixed, stomach_gas, kStomachReach_m, dark_hu);
        stomach.mask = without(withWall(s, stomach_gas, fluid), other_gas);
        stomach.confidence = std::clamp(0.3 + 0.4 * choice.lead, 0.3, 0.7);
        if (stomach.confidence < 0.5)
            stomach.note = "stomach: other gas lies as near to where it is expected";
    } else {
        stomach.note = "stomach: no gas below the left dome, so it was not looked for";
    }
    if (countOf(other_gas) > 0) {
        colon.mask = withWall(s, other_gas, fluidOf(s, mixed, other_gas, kColonReach_m, dark_hu));
        colon.mask = without(without(colon.mask, stomach.mask), gas);
        colon.confidence = 0.4;
        colon.note = "colon: gas of the small bowel is not told apart from it";
    } else {
        colon.note = "colon: no gas that would show it";
    }
    const bool any = countOf(gas) > 0;
    return {std::move(stomach), std::move(colon),
            FoundOrgan{"bowel gas", gas, any ? 0.95 : 0.0, any ? "" : "bowel gas: none"}};
}

}  // namespace stylet::modeller
