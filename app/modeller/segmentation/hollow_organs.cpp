// Finds the hollow organs, each by what shows it. Stomach: gas at its usual place, and the fluid behind that
// gas. Colon: stool and gas. Small bowel: the soft tissue left over in front of kidneys and great vessels.
// Their walls are added.
#include <algorithm>
#include <cmath>

#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/organ_scene.h"
#include "base/statistics.h"

namespace stylet::modeller {

namespace {

constexpr double kGutWall_m = 0.003;
constexpr double kMinGas_ml = 0.5;  // smaller bubbles are ignored

struct GasPiece {
    double volume_ml = 0.0;
    double position_score = 0.0;  // mean of stomachPositionScore()
};

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

// Returns the fluid behind the levels of an organ's gas. It has the HU of dark soft tissue. Fluid and gas
// together contain balls of radius `width_m`, which a narrower organ beside it does not. Narrower ends are
// added up to 8 mm from there.
Mask findFluid(const OrganScene& s, const FloatVolume& mixed, const Mask& gas, double width_m,
               double high_hu) {
    constexpr double kFat_hu = -30.0, kBodyReach_m = 0.090, kEnd_m = 0.008, kEndReach_m = 0.008;
    const FluidLevels levels = findFluidLevels(s, gas);
    if (levels.y < 0) return Mask(s.grid);
    Mask soft = inRange(mixed, s.free, kFat_hu, high_hu);
    forEachVoxel(VoxelBox{{0, levels.y + 1, 0}, s.grid.dims - 1}, [&](const Index3& i) { soft[i] = 0; });
    soft = unite(std::move(soft), levels.below);
    const Mask wide = intersect(opened(unite(soft, gas), width_m), soft);
    const Mask body = growWithin(levels.below, unite(wide, levels.below), kBodyReach_m);
    return opened(growWithin(body, unite(opened(soft, kEnd_m), body), kEndReach_m), kGutWall_m);
}

// Adds the wall around gas and fluid. The blurred surface of the gas counts as wall.
Mask addWall(const OrganScene& s, const Mask& gas, const Mask& fluid) {
    constexpr double kFat_hu = -30.0, kMaxWall_hu = 400.0;
    const Mask rim = intersect(dilated(gas, std::max(kGutWall_m, 1.8 * s.grid.spacing_m.x)), s.free);
    const Mask wall =
        intersect(dilated(unite(gas, fluid), kGutWall_m), inRange(s.smooth_hu, s.free, kFat_hu, kMaxWall_hu));
    return subtract(unite(unite(rim, wall), fluid), intersect(s.gas, s.free_wide));
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

// Marks the pieces of gas that lie directly above this fluid or stool: in the same organ.
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

constexpr double kStool_hu = 35.0;        // stool is darker on average
constexpr double kStoolShows_m = 0.0021;  // larger voxels do not show the mixture
bool showsStool(const OrganScene& s) {
    return s.grid.spacing_m.x <= kStoolShows_m;
}

// Variance of the values within a few millimetres, among the voxels of `within` alone: edges of other tissue
// do not add to it. `mean` is the local mean. On the grid of the box; 0 outside `within`.
FloatVolume localVariance(const FloatVolume& hu, const FloatVolume& mean, const Mask& within,
                          const VoxelBox& box) {
    constexpr double kReach_m = 0.003;
    const int reach = std::max(1, int(std::lround(kReach_m / hu.grid.spacing_m.x)));
    const Mask part = cropped(within, box);
    FloatVolume variance(part.grid);
    forEachVoxel(part.grid, [&](const Index3& i) {
        const float d = hu[box.low + i] - mean[box.low + i];
        if (part[i]) variance[i] = d * d;
    });
    variance = boxMean(variance, reach);
    const FloatVolume count = boxMean(toFloat(part), reach);
    for (std::size_t i = 0; i < variance.voxels.size(); ++i)
        variance.voxels[i] = part.voxels[i] ? variance.voxels[i] / count.voxels[i] : 0.0f;
    return variance;
}

// Removes the surroundings of the spine, where vessels, kidneys and muscles lie, but no bowel. In the flanks,
// only voxels less than `flank_y_m` in front of the canal are removed. Lengths are those of adults.
void removeNearSpine(const OrganScene& s, double flank_y_m, Mask& mask) {
    constexpr double kMiddle_m = 0.060, kBeforeVessels_m = 0.055;
    forEachVoxel(s.grid, [&](const Index3& i) {
        const Vec3 d = s.fromCanal(i);
        if (d.y < (std::fabs(d.x) < kMiddle_m ? kBeforeVessels_m : flank_y_m)) mask[i] = 0;
    });
}

// Returns the colon's stool, up to its border. Stool mixes gas, fat and soft tissue: its values vary within
// millimetres by more than noise, while fluid and the contents of the small bowel are even. In the mesentery
// they vary too, but there they are those of fat and of bright vessels.
Mask findStool(const OrganScene& s, const FloatVolume& mixed, double organs_hu) {
    constexpr double kFat_hu = -60.0, kBlurred_m = 0.004, kCore_m = 0.003, kMinCore_ml = 2.0, kRim_m = 0.0045,
                     kVessels_m = 0.005;
    constexpr double kBack_m = -0.020;  // farther back, there are only the muscles of the back
    if (!showsStool(s)) return Mask(s.grid);
    // kUsual_hu: the noise, if there is no liver. kScatter: the variance of few voxels is uncertain.
    constexpr float kUneven_hu = 9.0f, kUsual_hu = 5.0f, kScatter = 1.6f, kMaxVessels = 0.02f;
    const Mask soft = subtract(inRange(mixed, s.free, kFat_hu, organs_hu), s.gas);
    const Mask deep = eroded(soft, kBlurred_m), liver = eroded(s.liver, kBlurred_m);
    const Mask looked_at = unite(deep, liver);
    const VoxelBox box = boundingBox(looked_at);
    if (box.empty()) return Mask(s.grid);
    FloatVolume variance = localVariance(s.edgeHu(), mixed, looked_at, box);
    std::vector<float> in_liver;
    forEachVoxel(variance.grid, [&](const Index3& i) {
        if (liver[box.low + i]) in_liver.push_back(variance[i]);
    });
    const float noise = in_liver.empty() ? kUsual_hu * kUsual_hu : upperMedian(std::move(in_liver));
    Mask core(s.grid);
    forEachVoxel(variance.grid, [&](const Index3& i) {
        const Index3 at = box.low + i;
        core[at] = deep[at] && mixed[at] < float(kStool_hu) &&
                   variance[i] > kScatter * noise + kUneven_hu * kUneven_hu;
    });
    variance = {};  // the memory is needed
    const double bright_hu = organs_hu + 2.0 * std::sqrt(double(noise));
    const FloatVolume vessels = boxMean(toFloat(cropped(inRange(s.edgeHu(), s.free, bright_hu, 1e6), box)),
                                        std::max(1, int(std::lround(kVessels_m / s.grid.spacing_m.x))));
    forEachVoxel(vessels.grid, [&](const Index3& i) { core[box.low + i] &= vessels[i] < kMaxVessels; });
    removeNearSpine(s, kBack_m, core);
    core = opened(core, kCore_m);
    removeSmallComponents(core, kMinCore_ml);
    return intersect(dilated(core, kRim_m), soft);
}

// Returns the gas of the colon and the stool between its bubbles. Gas is the colon's if it lies above stool,
// is wider than a loop of the small bowel, or consists of bubbles. If voxels do not show stool, all gas is
// taken for the colon's.
Mask findColonGas(const OrganScene& s, const Mask& gas, const Mask& stool) {
    constexpr double kWide_m = 0.010, kBubble_m = 0.004, kBubbly = 0.25;
    const Mask filled = intersect(closed(gas, kBubble_m), unite(s.free, gas));
    const Components p = findComponents(filled);
    const std::vector<bool> over = findOverFluid(s, p, filled, stool);
    const Mask core = eroded(filled, kWide_m);
    std::vector<bool> wide(p.size.size(), false);
    std::vector<double> between(p.size.size(), 0.0);
    for (std::size_t i = 0; i < core.voxels.size(); ++i) {
        const auto n = std::size_t(p.number.voxels[i]);
        if (core.voxels[i]) wide[n] = true;
        between[n] += filled.voxels[i] && !gas.voxels[i];
    }
    return componentsWhere(p, [&](std::size_t n) {
        const double size_ml = double(p.size[n]) * voxelVolume_ml(s.grid);
        return size_ml >= kMinGas_ml &&
               (!showsStool(s) || over[n] || wide[n] || between[n] > kBubbly * double(p.size[n]));
    });
}

// Returns the loops of the small bowel: soft, darker than organs, in front of kidneys and great vessels.
Mask findSmallBowel(const OrganScene& s, const Mask& gas, const Mask& others, double dark_hu) {
    constexpr double kSoft_hu = -10.0, kThin_m = 0.005, kMinLoop_ml = 5.0, kBeforeKidneys_m = 0.020;
    Mask soft = subtract(subtract(inRange(s.smooth_hu, s.free, kSoft_hu, dark_hu), others), s.gas);
    removeNearSpine(s, kBeforeKidneys_m, soft);
    Mask loops = opened(soft, kThin_m);
    removeSmallComponents(loops, kMinLoop_ml);
    return subtract(addWall(s, gas, loops), others);
}

struct Stomach {
    FoundOrgan organ;
    Mask gas;
};

Stomach findStomach(const OrganScene& s, const FloatVolume& mixed, const Mask& gas, double dark_hu) {
    Stomach out{{"stomach and oesophagus", Mask(s.grid), 0.0, ""}, {}};
    constexpr double kWidth_m = 0.016;  // wider than a loop of the small bowel
    FoundOrgan& stomach = out.organ;
    StomachChoice choice;
    Mask other_gas;
    {  // the components are large: free them before the fluid is searched
        const Components p = findComponents(gas);
        const std::vector<GasPiece> pieces = measureGas(s, p, s.left_dome_m);
        choice = chooseStomach(pieces);
        out.gas = componentsWhere(p, [&](std::size_t n) { return n == choice.piece; });
        other_gas = componentsWhere(
            p, [&](std::size_t n) { return n != choice.piece && pieces[n].volume_ml >= kMinGas_ml; });
    }
    if (choice.piece == 0) {
        stomach.note = "stomach: no gas below the left dome, so it was not looked for";
        return out;
    }
    const Mask fluid = findFluid(s, mixed, out.gas, kWidth_m, dark_hu);
    const Components others = findComponents(other_gas);
    const std::vector<bool> joins = findOverFluid(s, others, other_gas, fluid);
    out.gas = unite(std::move(out.gas), componentsWhere(others, [&](std::size_t n) { return joins[n]; }));
    stomach.mask = subtract(addWall(s, out.gas, findFluid(s, mixed, out.gas, kWidth_m, dark_hu)),
                            subtract(other_gas, out.gas));
    stomach.confidence = std::clamp(0.3 + 0.4 * choice.margin, 0.3, 0.7);
    if (stomach.confidence < 0.5) stomach.note = "stomach: other gas lies as near to where it is expected";
    return out;
}

}  // namespace

std::vector<FoundOrgan> findHollowOrgans(const OrganScene& s, double organs_hu) {
    constexpr double kBelowOrgans_hu = 22.0, kMixed_m = 0.003, kColonWidth_m = 0.010;
    const Mask gas = intersect(s.gas, s.free_wide);
    const double dark_hu = organs_hu - kBelowOrgans_hu;
    // Chyme and stool are mixtures from fat to soft tissue, in patches of a few millimetres.
    FloatVolume mixed = boxMean(toFloat(s.ct), std::max(1, int(kMixed_m / s.grid.spacing_m.x)));
    FoundOrgan colon{"colon", Mask(s.grid), 0.0, ""}, small_bowel{"small bowel", Mask(s.grid), 0.0, ""};
    Stomach stomach = findStomach(s, mixed, gas, dark_hu);
    Mask other_gas = subtract(gas, stomach.gas);
    Mask stool = subtract(findStool(s, mixed, organs_hu), stomach.organ.mask);
    if (showsStool(s)) mixed = {};  // its memory is needed for small voxels
    const Mask colon_gas = findColonGas(s, other_gas, stool);
    if (!showsStool(s)) stool = findFluid(s, mixed, colon_gas, kColonWidth_m, kStool_hu);
    colon.mask = subtract(addWall(s, colon_gas, stool), stomach.organ.mask);
    if (countVoxels(colon.mask) > 0) {
        const bool stool_shows = showsStool(s) && countVoxels(stool) > 0;
        colon.confidence = stool_shows ? 0.65 : 0.3;
        if (!stool_shows) colon.note = "colon: no stool shows it, only its gas and dark contents";
    } else {
        colon.note = "colon: neither stool nor wide gas shows it";
    }
    removeSmallComponents(other_gas, kMinGas_ml);
    small_bowel.mask =
        findSmallBowel(s, subtract(other_gas, colon_gas), unite(stomach.organ.mask, colon.mask), dark_hu);
    if (countVoxels(small_bowel.mask) > 0)
        small_bowel.confidence = 0.6;
    else
        small_bowel.note = "small bowel: no soft loops in front of the kidneys";
    const bool any_gas = countVoxels(gas) > 0;
    return {std::move(stomach.organ), std::move(colon), std::move(small_bowel),
            FoundOrgan{"bowel gas", gas, any_gas ? 0.95 : 0.0, any_gas ? "" : "bowel gas: none"}};
}

}  // namespace stylet::modeller
