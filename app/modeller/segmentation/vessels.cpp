#include "app/modeller/segmentation/vessels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "app/modeller/segmentation/tube_evidence.h"
#include "base/geodesic.h"
#include "base/statistics.h"

namespace stylet::modeller {

namespace {

const std::vector<double> kVesselRadii_m{0.001, 0.0015, 0.0021, 0.003, 0.0045};
// Thresholds of TubeEvidence::score. Tuned on the reference patients of seeds 5 to 7; between 6 and 7 at 1
// mm, 7 was chosen after scoring a real patient. At 1 mm, the strictest value that loses nothing. In wider
// voxels vessels score less, because most of their voxels are partly parenchyma.
constexpr double kInsideVessel = 7.0, kInsideLess_per_m = 2000.0, kLeastInside = 5.0, kFine_m = 0.001;
constexpr float kCertainVessel = 9.0f;
constexpr double kLeastVesselPiece_m3 = 200e-9;  // 15 mm of a vessel of 2 mm radius
// Minimum share of the blood's contrast to parenchyma. Otherwise, with little noise, a vessel's entire
// blurred rim would score.
constexpr double kLevelShare = 0.35;
// A vessel's wall lies halfway to its own centre, less the effect of blur on a curved wall. kMiddle_m is
// the search distance for the centre.
constexpr float kWallShare = 0.45f;
constexpr double kMiddle_m = 0.0021;
// Where the liver's mask includes the rim of something bright, that rim is a sheet, not a line.
constexpr double kLiverRim_m = 0.003;
constexpr float kRimLine = 2.0f;

// Blood in the large vessels: blur, minimum share of the contrast from parenchyma to the vessels' level,
// and maximum excess over that level. The walls between touching vessels are blurred, but darker than the
// blood.
constexpr double kLumenBlur_m = 0.0007, kLumenShare = 0.5;
constexpr double kBloodBlur_m = 0.0015, kBloodShare = 0.35, kBloodAbove_hu = 90.0;
constexpr double kAround_m = 0.015;  // around the liver, where cava and hilum are searched
// The cava in a slice: opened to remove joining vessels, and of this area (5 to 22 mm radius).
constexpr double kCavaOpening_m = 0.004, kLeastCava_m2 = 70e-6, kMostCava_m2 = 1500e-6;
constexpr double kCavaLeastLength_m = 0.012;
// Minimum half width as a share of the cava's: narrower than a flat cava, wider than a portal trunk.
constexpr double kOwnWidth = 0.7;
constexpr double kNearLiver_m = 0.005, kNearVessels_m = 0.006;
constexpr double kTrunkRadius_m = 0.0035, kCavaWall_m = 0.002, kOffCava_m = 0.006, kDeepInLiver_m = 0.008;
// Heights in the liver, 0 at its lowest and 1 at its highest voxel: of the hilum and of the hepatic veins'
// ends.
constexpr double kTrunkLow = 0.2, kTrunkHigh = 0.62, kVeinsLow = 0.65, kStemsLow = 0.78, kStemReach_m = 0.035;
constexpr float kStemWidth = 0.75f;
constexpr double kJoin_m = 0.005;  // from a vessel's end to the large vessel that it joins
// Costs of the fronts, in metres of wide lumen: narrow contacts, jumps through parenchyma, and each metre
// by which a lumen widens.
constexpr double kNarrow_m = 0.002, kLeap = 60.0, kWall = 12.0, kBeyondLiver = 120.0, kWidening = 25.0;
constexpr double kNoLumen_m = 0.0008;

// The liver's surroundings, in which the vessels are separated.
struct Scene {
    VoxelBox box;
    Mask liver, vessels, blood;
    Mask lumen;                        // the certainly bright inside of the vessels
    FloatVolume to_liver, to_vessels;  // metres
    int bottom = 0, top = 0;           // slices of the liver in the box

    // Height within the liver, 0 to 1.
    double height(int z) const { return double(z - bottom) / double(std::max(1, top - bottom)); }
};

Scene vesselScene(const CtVolume& ct, const Mask& liver, const Mask& vessels) {
    Scene s;
    s.box = boxAround(liver, int(std::ceil(kAround_m / ct.grid.spacing_m.x)));
    s.liver = cropped(liver, s.box);
    s.vessels = cropped(vessels, s.box);
    const VoxelBox inside = boxAround(s.liver, 0);
    s.bottom = inside.low.z, s.top = inside.high.z;
    s.to_liver = distanceTo(s.liver);
    s.to_vessels = distanceTo(s.vessels);

    FloatVolume image(s.liver.grid);
    std::vector<float> in_liver, in_vessels;
    std::size_t o = 0;
    for (int z = s.box.low.z; z <= s.box.high.z; ++z)
        for (int y = s.box.low.y; y <= s.box.high.y; ++y)
            for (int x = s.box.low.x; x <= s.box.high.x; ++x, ++o) {
                image.voxels[o] = std::clamp(float(ct[{x, y, z}]), -200.0f, 600.0f);
                if (s.liver.voxels[o])
                    (s.vessels.voxels[o] ? in_vessels : in_liver).push_back(image.voxels[o]);
            }
    s.blood = s.lumen = Mask(s.liver.grid);
    if (in_liver.empty() || in_vessels.empty()) return s;
    // Most voxels of a thin vessel are partly parenchyma; the upper quartile is blood.
    const double parenchyma_hu = double(lowerQuantile(std::move(in_liver), 0.5)),
                 blood_hu = double(lowerQuantile(std::move(in_vessels), 0.75));
    const double least_hu = parenchyma_hu + kBloodShare * (blood_hu - parenchyma_hu);
    const FloatVolume sharp = gaussian(image, kLumenBlur_m);
    const double lumen_hu = parenchyma_hu + kLumenShare * (blood_hu - parenchyma_hu);
    for (std::size_t i = 0; i < sharp.voxels.size(); ++i)
        s.lumen.voxels[i] = s.vessels.voxels[i] && double(sharp.voxels[i]) > lumen_hu;
    image = gaussian(image, kBloodBlur_m);
    for (std::size_t i = 0; i < image.voxels.size(); ++i)
        s.blood.voxels[i] = double(image.voxels[i]) > least_hu &&
                            double(image.voxels[i]) < blood_hu + kBloodAbove_hu &&
                            double(s.to_liver.voxels[i]) < kAround_m;
    return s;
}

// Cross-sections of large blood vessels in each slice, as offsets within the slice.
std::vector<std::vector<Piece>> crossSections(const Scene& s) {
    const Grid& g = s.blood.grid;
    const Grid flat{{g.dims.x, g.dims.y, 1}, g.spacing_m, g.origin_m};
    const double voxel_m2 = g.spacing_m.x * g.spacing_m.y;
    std::vector<std::vector<Piece>> sections(std::size_t(g.dims.z));
    for (int z = s.bottom; z <= s.top; ++z) {
        Mask slice(flat);
        const auto from = s.blood.voxels.begin() + std::ptrdiff_t(z) * std::ptrdiff_t(flat.voxelCount());
        std::copy(from, from + std::ptrdiff_t(flat.voxelCount()), slice.voxels.begin());
        keepPieces(dilated(eroded(slice, kCavaOpening_m), kCavaOpening_m), [&](const Piece& piece) {
            const double area_m2 = double(piece.size()) * voxel_m2;
            if (area_m2 >= kLeastCava_m2 && area_m2 <= kMostCava_m2)
                sections[std::size_t(z)].push_back(piece);
            return false;
        });
        for (Piece& piece : sections[std::size_t(z)])
            std::sort(piece.begin(), piece.end());
    }
    return sections;
}

// Returns the section of the next slice that continues this one, or null.
const Piece* continued(const Piece& from, const std::vector<Piece>& next) {
    for (const Piece& piece : next) {
        Piece both;
        std::set_intersection(from.begin(), from.end(), piece.begin(), piece.end(), std::back_inserter(both));
        const bool overlaps = 2 * both.size() > std::min(from.size(), piece.size());
        if (overlaps && piece.size() < 2 * from.size() && from.size() < 2 * piece.size()) return &piece;
    }
    return nullptr;
}

// Where the portal trunk or a hepatic vein's stem touches the cava, a section contains both. Keeps the
// parts that are nearly as wide as the cava is in most slices, plus one voxel for the corners that the
// opening removes.
Mask ownSections(const Mask& chain) {
    const Grid& g = chain.grid;
    const Grid flat{{g.dims.x, g.dims.y, 1}, g.spacing_m, g.origin_m};
    const auto from = [&](int z) {
        return chain.voxels.begin() + std::ptrdiff_t(z) * std::ptrdiff_t(flat.voxelCount());
    };
    std::vector<double> half_m(std::size_t(g.dims.z)), there_m;
    Mask slice(flat);
    for (int z = 0; z < g.dims.z; ++z) {
        std::copy_n(from(z), flat.voxelCount(), slice.voxels.begin());
        if (countOf(slice) == 0) continue;
        const FloatVolume to_wall = distanceTo(inverted(slice));
        half_m[std::size_t(z)] = double(*std::max_element(to_wall.voxels.begin(), to_wall.voxels.end()));
        there_m.push_back(half_m[std::size_t(z)]);
    }
    if (there_m.empty()) return chain;
    const double usual_m = upperMedian(std::move(there_m));

    Mask own(g);
    for (int z = 0; z < g.dims.z; ++z) {
        std::copy_n(from(z), flat.voxelCount(), slice.voxels.begin());
        const double opening_m = kOwnWidth * std::min(usual_m, half_m[std::size_t(z)]);
        slice = both(slice, dilated(eroded(slice, opening_m), opening_m + g.spacing_m.x));
        std::copy(slice.voxels.begin(), slice.voxels.end(),
                  own.voxels.begin() + std::ptrdiff_t(z) * std::ptrdiff_t(flat.voxelCount()));
    }
    keepLargest(own);
    return own;
}

// The cava: among all upright vessels in the back of the liver's upper part, the one that is nearest to
// liver and vessels for the longest distance.
Mask cavaOf(const Scene& s) {
    const Grid& g = s.blood.grid;
    const std::size_t slice = std::size_t(g.dims.x) * std::size_t(g.dims.y);
    const VoxelBox liver = boxAround(s.liver, 0);
    const auto sections = crossSections(s);
    const double middle = 0.5 * (liver.low.y + liver.high.y) + 0.15 * (liver.high.y - liver.low.y);

    Mask best(g), seen(g);
    double best_score = 0.0;
    for (int z = s.top; z >= s.bottom; --z) {
        if (s.height(z) < 0.55 || s.height(z) > 0.97) continue;
        for (const Piece& start : sections[std::size_t(z)]) {
            if (seen.voxels[std::size_t(z) * slice + start.front()]) continue;
            std::vector<std::pair<int, const Piece*>> chain{{z, &start}};
            for (const int step : {1, -1}) {
                const Piece* at = &start;
                for (int to = z + step; to >= s.bottom && to <= s.top; to += step) {
                    at = continued(*at, sections[std::size_t(to)]);
                    if (!at) break;
                    chain.push_back({to, at});
                }
            }
            double score = 0.0, y_sum = 0.0, count = 0.0;
            for (const auto& [level, piece] : chain)
                for (const std::size_t o : *piece) {
                    const std::size_t i = std::size_t(level) * slice + o;
                    seen.voxels[i] = 1;
                    score += double(s.to_vessels.voxels[i]) < kNearVessels_m && s.height(level) > 0.5;
                    score += 0.3 * (double(s.to_liver.voxels[i]) < kNearLiver_m);
                    y_sum += double(o / std::size_t(g.dims.x));
                    count += 1.0;
                }
            if (double(chain.size()) * g.spacing_m.z < kCavaLeastLength_m || y_sum > middle * count) continue;
            if (score <= best_score) continue;
            best_score = score;
            best = Mask(g);
            for (const auto& [level, piece] : chain)
                for (const std::size_t o : *piece)
                    best.voxels[std::size_t(level) * slice + o] = 1;
        }
    }
    return ownSections(best);
}

// The portal trunk and its branches: among all thick blood at the liver's middle heights, away from the
// cava, the piece that touches most of the vessels deep in the liver. Blood connected outside the cava's
// wall is one piece; voxels next to the wall are neither counted nor kept. Vessels near the surface are not
// counted, because a mask that is too large includes rims of cava and kidney.
Mask portalTrunk(const Scene& s, const Mask& cava) {
    const Grid& g = s.blood.grid;
    const FloatVolume to_cava = distanceTo(cava);
    Mask thick = dilated(eroded(s.blood, kTrunkRadius_m), kTrunkRadius_m);
    for (std::size_t i = 0; i < thick.voxels.size(); ++i) {
        const double height = s.height(g.voxelAt(i).z);
        if (height < kTrunkLow || height > kTrunkHigh || double(to_cava.voxels[i]) < kCavaWall_m)
            thick.voxels[i] = 0;
    }
    const FloatVolume to_deep = distanceTo(both(s.vessels, eroded(s.liver, kDeepInLiver_m)));
    const auto off_cava = [&](std::size_t o) { return double(to_cava.voxels[o]) >= kOffCava_m; };
    std::size_t most = 0;
    Piece trunk;
    keepPieces(thick, [&](const Piece& piece) {
        const auto met = std::size_t(std::count_if(piece.begin(), piece.end(), [&](std::size_t o) {
            return off_cava(o) && double(to_deep.voxels[o]) < kNearVessels_m;
        }));
        if (met > most) most = met, trunk = piece;
        return false;
    });
    Mask out(g);
    for (const std::size_t o : trunk)
        out.voxels[o] = off_cava(o);
    return out;
}

FloatVolume lumenRadius(const Mask& vessels) {
    FloatVolume radius(vessels.grid);
    LabelSet set{};
    set[1] = true;
    for (const VoxelPiece& piece : piecesOf(vessels, set)) {
        const std::vector<double> r = lumenRadius_m(piece, wallDistance_m(piece));
        for (std::size_t m = 0; m < piece.size(); ++m)
            radius[piece.voxel(m)] = float(r[m]);
    }
    return radius;
}

constexpr std::uint8_t kPortal = 1, kHepatic = 2;

// Dijkstra's algorithm from all seeds at once: each vessel voxel gets the label of the front that reaches
// it first.
Mask runFronts(const Scene& s, const Mask& seeds, const FloatVolume& radius) {
    const Grid& g = s.vessels.grid;
    Mask label(g);
    std::vector<float> cost(g.voxelCount(), std::numeric_limits<float>::infinity());
    using Entry = std::pair<float, std::size_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    for (std::size_t i = 0; i < cost.size(); ++i)
        if (seeds.voxels[i]) cost[i] = 0.0f, label.voxels[i] = seeds.voxels[i], open.push({0.0f, i});
    std::size_t left = countOf(s.vessels);
    while (!open.empty() && left > 0) {
        const auto [so_far, o] = open.top();
        open.pop();
        if (so_far > cost[o]) continue;
        left -= s.vessels.voxels[o] != 0;
        const Index3 at = g.voxelAt(o);
        const Index3 low = glm::max(at - 1, Index3(0)), high = glm::min(at + 1, g.dims - 1);
        const double here_m = s.lumen.voxels[o] ? double(radius.voxels[o]) : kNoLumen_m;
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x) {
                    const std::size_t t = g.offset({x, y, z});
                    if (t == o) continue;
                    const double step_m = glm::length(g.spacing_m * Vec3(Index3(x, y, z) - at));
                    double next = double(so_far);
                    if (s.lumen.voxels[t]) {
                        const double there_m = double(radius.voxels[t]), narrow = kNarrow_m / there_m;
                        next +=
                            step_m * (1.0 + narrow * narrow) + kWidening * std::max(0.0, there_m - here_m);
                    } else {
                        next += step_m * (s.vessels.voxels[t] ? kWall
                                          : s.liver.voxels[t] ? kLeap
                                                              : kBeyondLiver);
                    }
                    if (float(next) >= cost[t]) continue;
                    cost[t] = float(next);
                    label.voxels[t] = label.voxels[o];
                    open.push({float(next), t});
                }
    }
    return label;
}

// Seeds the vessel voxels within reach of a large vessel.
void seedNear(const Scene& s, const Mask& large, std::uint8_t label, double least_height, Mask& seeds) {
    const FloatVolume to = distanceTo(large);
    for (std::size_t i = 0; i < seeds.voxels.size(); ++i)
        if (s.vessels.voxels[i] && double(to.voxels[i]) <= kJoin_m &&
            s.height(seeds.grid.voxelAt(i).z) >= least_height)
            seeds.voxels[i] = label;
}

// Fallback if no large vessel was found: seeds the widest lumen between two heights of the liver.
void seedWidest(const Scene& s, const FloatVolume& radius, double from, double to, std::uint8_t label,
                Mask& seeds) {
    std::size_t best = 0;
    float widest = 0.0f;
    for (std::size_t i = 0; i < radius.voxels.size(); ++i) {
        const double height = s.height(seeds.grid.voxelAt(i).z);
        if (radius.voxels[i] > widest && height >= from && height < to && !seeds.voxels[i])
            widest = radius.voxels[i], best = i;
    }
    if (widest > 0.0f) seeds.voxels[best] = label;
}

// Seeds all lumen in the liver's upper part that is nearly as wide as the widest there: the stems of the
// hepatic veins, even if their connection to the cava was not found.
void seedStems(const Scene& s, const FloatVolume& radius, const Mask& cava, Mask& seeds) {
    const FloatVolume to_cava = distanceTo(cava);
    const bool found = countOf(cava) > 0;
    float widest = 0.0f;
    for (int pass = 0; pass < 2; ++pass)
        for (std::size_t i = 0; i < radius.voxels.size(); ++i) {
            if (seeds.voxels[i] || !s.vessels.voxels[i]) continue;
            if (s.height(seeds.grid.voxelAt(i).z) < kStemsLow) continue;
            if (found && double(to_cava.voxels[i]) > kStemReach_m) continue;
            if (pass == 0) widest = std::max(widest, radius.voxels[i]);
            if (pass == 1 && radius.voxels[i] > kStemWidth * widest) seeds.voxels[i] = kHepatic;
        }
}

bool holds(const Mask& seeds, std::uint8_t label) {
    return std::find(seeds.voxels.begin(), seeds.voxels.end(), label) != seeds.voxels.end();
}

// The contrast of blood over parenchyma after the blur: upper quartile of the voxels that are certainly
// vessel; 0 if there are none.
double bloodContrast(const TubeEvidence& e) {
    std::vector<float> values;
    for (std::size_t i = 0; i < e.liver.voxels.size(); ++i)
        if (e.liver.voxels[i] && e.score(i) > kCertainVessel) values.push_back(e.contrast_hu.voxels[i]);
    return double(lowerQuantile(std::move(values), 0.75));
}

// Maximum contrast of `inside` within kMiddle_m of each of its voxels.
FloatVolume middlesOf(const FloatVolume& contrast_hu, const Mask& inside) {
    const Grid& g = inside.grid;
    const int reach = int(kMiddle_m / g.spacing_m.x);
    FloatVolume out(g);
    forEachSlab(g.dims.z, [&](int z) {
        for (int y = 0; y < g.dims.y; ++y)
            for (int x = 0; x < g.dims.x; ++x) {
                const Index3 at{x, y, z};
                if (!inside[at]) continue;
                const Index3 low = glm::max(at - reach, Index3(0)), high = glm::min(at + reach, g.dims - 1);
                float most = contrast_hu[at];
                for (int k = low.z; k <= high.z; ++k)
                    for (int j = low.y; j <= high.y; ++j)
                        for (int i = low.x; i <= high.x; ++i) {
                            const Index3 to{i, j, k};
                            if (inside[to] && glm::length(g.spacing_m * Vec3(to - at)) <= kMiddle_m)
                                most = std::max(most, contrast_hu[to]);
                        }
                out[at] = most;
            }
    });
    return out;
}

}  // namespace

Mask findVessels(const CtVolume& ct, const Mask& liver) {
    if (countOf(liver) == 0) return Mask(ct.grid);
    const TubeEvidence e = tubeEvidence(ct, liver, TubeKind::bright, kVesselRadii_m);
    const Mask core = eroded(e.liver, kLiverRim_m);
    const double least_hu = kLevelShare * bloodContrast(e);
    const double wider_m = std::max(0.0, ct.grid.spacing_m.x - kFine_m);
    const double least_score = std::max(kLeastInside, kInsideVessel - kInsideLess_per_m * wider_m);
    Mask inside(e.liver.grid);
    for (std::size_t i = 0; i < inside.voxels.size(); ++i)
        inside.voxels[i] = e.liver.voxels[i] && double(e.score(i)) > least_score &&
                           double(e.contrast_hu.voxels[i]) > least_hu &&
                           (core.voxels[i] || e.line.voxels[i] > kRimLine);
    const FloatVolume middle = middlesOf(e.contrast_hu, inside);
    for (std::size_t i = 0; i < inside.voxels.size(); ++i)
        inside.voxels[i] = inside.voxels[i] && e.contrast_hu.voxels[i] > kWallShare * middle.voxels[i];
    const auto least = std::size_t(kLeastVesselPiece_m3 / (1e-6 * voxelVolume_ml(ct.grid)));
    const Mask vessels = keepPieces(inside, [&](const Piece& piece) {
        return piece.size() >= least && std::any_of(piece.begin(), piece.end(), [&](std::size_t o) {
                   return e.score(o) > kCertainVessel;
               });
    });
    return restored(vessels, e.box, ct.grid);
}

SplitVessels splitVessels(const CtVolume& ct, const Mask& liver, const Mask& vessels) {
    SplitVessels out{Mask(ct.grid), Mask(ct.grid), Mask(ct.grid), {}};
    if (countOf(vessels) == 0 || countOf(liver) == 0) {
        out.notes.push_back("No vessels show in the liver: the scan has too little contrast medium in them.");
        return out;
    }
    const Scene s = vesselScene(ct, liver, vessels);
    const FloatVolume radius = lumenRadius(s.lumen);
    Mask cava = cavaOf(s);
    const Mask trunk = portalTrunk(s, cava);
    Mask seeds(s.vessels.grid);
    seedNear(s, trunk, kPortal, 0.0, seeds);
    seedNear(s, cava, kHepatic, kVeinsLow, seeds);
    seedStems(s, radius, cava, seeds);
    if (!holds(seeds, kPortal)) {
        out.notes.push_back(
            "No portal trunk was found at the hilum: the portal vein begins at the widest vessel "
            "of the liver's middle.");
        seedWidest(s, radius, kTrunkLow, kTrunkHigh, kPortal, seeds);
    }
    if (!holds(seeds, kHepatic)) {
        out.notes.push_back(
            "No cava was found behind the liver: the hepatic veins begin at the widest vessel "
            "of its upper part.");
        seedWidest(s, radius, kVeinsLow, 1.01, kHepatic, seeds);
    }
    if (!holds(seeds, kPortal) && !holds(seeds, kHepatic)) seedWidest(s, radius, -0.01, 1.01, kPortal, seeds);
    const Mask label = runFronts(s, seeds, radius);
    Mask portal(label.grid), hepatic(label.grid);
    for (std::size_t i = 0; i < label.voxels.size(); ++i) {
        if (s.vessels.voxels[i]) (label.voxels[i] == kHepatic ? hepatic : portal).voxels[i] = 1;
        if (s.vessels.voxels[i]) cava.voxels[i] = 0;
    }
    out.portal = restored(portal, s.box, ct.grid);
    out.hepatic = restored(hepatic, s.box, ct.grid);
    out.cava = restored(cava, s.box, ct.grid);
    return out;
}

}  // namespace stylet::modeller
