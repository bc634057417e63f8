#include "app/modeller/segmentation/vessels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "app/modeller/image/cheapest_paths.h"
#include "app/modeller/image/graph_cut.h"
#include "app/modeller/segmentation/tube_evidence.h"
#include "base/geodesic.h"
#include "base/statistics.h"

namespace stylet::modeller {

namespace {

const std::vector<double> kVesselRadii_m{0.001, 0.0015, 0.0021, 0.003, 0.0045};
// Thresholds of TubeEvidence::score, tuned on the reference patients of seeds 5 to 7. At 1 mm, 7 was
// preferred to 6 after scoring a real patient. It is the strictest value that loses no vessel at 1 mm. In
// wider voxels vessels score less, because most of their voxels are partly parenchyma.
constexpr double kInsideVessel = 7.0, kInsideLess_per_m = 2000.0, kMinInside = 5.0, kFine_m = 0.001;
constexpr float kCertainVessel = 9.0f;
constexpr double kMinVesselPiece_m3 = 200e-9;  // 15 mm of a vessel of 2 mm radius
// Minimum contrast, as a share of the contrast between blood and parenchyma. Without this limit and with
// little noise, the entire blurred rim of a vessel would score.
constexpr double kLevelShare = 0.35;
// Suspected vessels may score less than the inside of a vessel by kSuspectedLess. They need less contrast, of
// which blur leaves little in a thin vessel. Planned paths that cross a true risk structure, in a real
// patient, three deformed copies of it and one reference patient: with 1.0 and a share of 0.35, 24 of 695;
// with 1.5 and 0.2, 8 of 664; with 2.0 and 0.2, 4 of 647; with 2.5 and 0.2, 2 of 629. Without kMinSuspected,
// two fifths of the paths are lost in voxels of 2 mm instead of one fifth.
constexpr double kSuspectedLess = 2.0, kSuspectedShare = 0.2, kMinSuspected = 4.0;
// The wall of a vessel is where the contrast is half of that at the vessel's centre, or slightly less,
// because blur acts on a curved wall. kMiddle_m is the search distance for the centre.
constexpr float kWallShare = 0.45f;
constexpr double kMiddle_m = 0.0021;
// Where the liver's mask includes the rim of a bright structure, that rim is a sheet, not a line.
constexpr double kLiverRim_m = 0.003;
constexpr float kRimLine = 2.0f;

// Limits for blood in the large vessels: blur, minimum contrast as a share of that of the other vessels, and
// maximum HU above these vessels.
constexpr double kBloodBlur_m = 0.0015, kBloodShare = 0.35, kBloodAbove_hu = 90.0;
constexpr double kAround_m = 0.015;  // around the liver, where cava and hilum are searched
// Cross-section of the cava in a slice. Opening removes joining vessels. The area must be that of
// 5 to 22 mm radius.
constexpr double kCavaOpening_m = 0.004, kMinCava_m2 = 70e-6, kMaxCava_m2 = 1500e-6;
constexpr double kMinCavaLength_m = 0.012;
// From the liver's back (0) to its front (1): where no cava lies. The portal trunk lies in front of the cava
// and may look like it, so a vessel within kCavaDepth of that counts less. A depth of 0.3 or 0.5 gives the
// same trees.
constexpr double kCavaFront = 0.65, kCavaDepth = 0.3;
// Minimum half width as a share of the cava's usual half width. A flat cava is wider, a portal trunk
// narrower.
constexpr double kOwnWidth = 0.7;
constexpr double kNearLiver_m = 0.005, kNearVessels_m = 0.006;
constexpr double kTrunkRadius_m = 0.0035, kCavaWall_m = 0.002, kOffCava_m = 0.006, kDeepInLiver_m = 0.008;
// Heights of the hilum and of the hepatic veins' ends in the liver: 0 is its lowest voxel and 1 its highest.
constexpr double kTrunkLow = 0.2, kTrunkHigh = 0.62, kVeinsLow = 0.65, kStemsLow = 0.78, kStemReach_m = 0.035;
constexpr double kAnyHeight = 1e9;
constexpr float kStemWidth = 0.75f;
// Maximum distance from a vessel's end to the large vessel that it joins. 1 to 3 mm give nearly the same
// trees. With 5 mm, hepatic veins that pass the portal trunk become seeds of the portal tree.
constexpr double kJoin_m = 0.002;
// Additional cost of a path outside the vessels where no contrast is left, relative to inside.
constexpr double kOutsideCost = 60.0;
// Additional cost of a path through a vessel wider than allowed, per excess of its radius as a share of the
// allowed one. Allowed is kWider times the narrowest place passed, and kThinRadius_m. With 3 instead of 8,
// portal branches are lost to the hepatic veins.
constexpr double kWideningCost = 8.0, kWider = 1.25, kThinRadius_m = 0.0012;
// Paths to the hepatic veins start farther away, at the top of the liver, so paths to the portal vein count
// this much more. kStep_m keeps their ratio finite at a seed; its logarithm is limited to kMaxNearer.
constexpr double kPortalFarther = 1.3, kStep_m = 0.001, kMaxNearer = 1.5;
// What a metre of vessel, a voxel wide, prefers by its path and by its course. A face of full contrast costs
// 1. With 0.7 of both, trees that touch are not separated in a real patient that was deformed; with 1.4 of
// both, a sixth of the hepatic veins of one reference patient (seed 33) becomes portal.
constexpr double kPathWeight_per_m = 2.0, kCourseWeight_per_m = 12.0, kCourseReach_m = 0.006;
// Minimum cost of a face of the cut. Without it, a dark voxel would be linked to nothing.
constexpr float kMinFaceCost = 0.001f;
constexpr float kCutUnits = 10.0f;  // minimumCut() rounds to a thousandth, so costs are scaled up

// The liver's surroundings, in which the vessels are separated.
struct Scene {
    VoxelBox box;
    Mask liver, vessels, blood;
    FloatVolume to_liver, to_vessels;  // metres
    FloatVolume contrast;              // over parenchyma, as a share of the vessels' contrast, 0 to 1
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
    forEachVoxel(image.grid, [&](const Index3& i) {
        image[i] = std::clamp(float(ct[s.box.low + i]), -200.0f, 600.0f);
        if (s.liver[i]) (s.vessels[i] ? in_vessels : in_liver).push_back(image[i]);
    });
    s.blood = Mask(s.liver.grid);
    s.contrast = FloatVolume(s.liver.grid);
    if (in_liver.empty() || in_vessels.empty()) return s;
    // Most voxels of a thin vessel are partly parenchyma, so the upper quartile is used for blood.
    const double parenchyma_hu = double(lowerQuantile(std::move(in_liver), 0.5)),
                 blood_hu = double(lowerQuantile(std::move(in_vessels), 0.75));
    const double min_hu = parenchyma_hu + kBloodShare * (blood_hu - parenchyma_hu);
    for (std::size_t i = 0; i < image.voxels.size(); ++i)
        s.contrast.voxels[i] = float(std::clamp(
            (double(image.voxels[i]) - parenchyma_hu) / std::max(1.0, blood_hu - parenchyma_hu), 0.0, 1.0));
    image = gaussian(image, kBloodBlur_m);
    for (std::size_t i = 0; i < image.voxels.size(); ++i)
        s.blood.voxels[i] = double(image.voxels[i]) > min_hu &&
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
        filterComponents(dilated(eroded(slice, kCavaOpening_m), kCavaOpening_m), [&](const Piece& piece) {
            const double area_m2 = double(piece.size()) * voxel_m2;
            if (area_m2 >= kMinCava_m2 && area_m2 <= kMaxCava_m2) sections[std::size_t(z)].push_back(piece);
            return false;
        });
        for (Piece& piece : sections[std::size_t(z)])
            std::sort(piece.begin(), piece.end());
    }
    return sections;
}

// Returns the section of the next slice that continues this one, or null.
const Piece* findContinuation(const Piece& from, const std::vector<Piece>& next) {
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
Mask trimSections(const Mask& chain) {
    const Grid& g = chain.grid;
    const Grid flat{{g.dims.x, g.dims.y, 1}, g.spacing_m, g.origin_m};
    const auto from = [&](int z) {
        return chain.voxels.begin() + std::ptrdiff_t(z) * std::ptrdiff_t(flat.voxelCount());
    };
    std::vector<double> half_m(std::size_t(g.dims.z)), there_m;
    Mask slice(flat);
    for (int z = 0; z < g.dims.z; ++z) {
        std::copy_n(from(z), flat.voxelCount(), slice.voxels.begin());
        if (countVoxels(slice) == 0) continue;
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
        slice = intersect(slice, dilated(eroded(slice, opening_m), opening_m + g.spacing_m.x));
        std::copy(slice.voxels.begin(), slice.voxels.end(),
                  own.voxels.begin() + std::ptrdiff_t(z) * std::ptrdiff_t(flat.voxelCount()));
    }
    keepLargestComponent(own);
    return own;
}

// Finds the cava: the vertical vessel in the back of the liver's upper part that stays near the liver and its
// vessels for the longest distance. A vessel farther back is preferred.
Mask segmentCava(const Scene& s) {
    const Grid& g = s.blood.grid;
    const std::size_t slice = std::size_t(g.dims.x) * std::size_t(g.dims.y);
    const VoxelBox liver = boxAround(s.liver, 0);
    const auto sections = crossSections(s);

    Mask best(g), visited(g);
    double best_score = 0.0;
    for (int z = s.top; z >= s.bottom; --z) {
        if (s.height(z) < 0.55 || s.height(z) > 0.97) continue;
        for (const Piece& start : sections[std::size_t(z)]) {
            if (visited.voxels[std::size_t(z) * slice + start.front()]) continue;
            std::vector<std::pair<int, const Piece*>> chain{{z, &start}};
            for (const int step : {1, -1}) {
                const Piece* at = &start;
                for (int to = z + step; to >= s.bottom && to <= s.top; to += step) {
                    at = findContinuation(*at, sections[std::size_t(to)]);
                    if (!at) break;
                    chain.push_back({to, at});
                }
            }
            double score = 0.0, y_sum = 0.0, count = 0.0;
            for (const auto& [level, piece] : chain)
                for (const std::size_t o : *piece) {
                    const std::size_t i = std::size_t(level) * slice + o;
                    visited.voxels[i] = 1;
                    score += double(s.to_vessels.voxels[i]) < kNearVessels_m && s.height(level) > 0.5;
                    score += 0.3 * (double(s.to_liver.voxels[i]) < kNearLiver_m);
                    y_sum += double(o / std::size_t(g.dims.x));
                    count += 1.0;
                }
            if (double(chain.size()) * g.spacing_m.z < kMinCavaLength_m) continue;
            const double from_back =
                (y_sum / count - liver.low.y) / double(std::max(1, liver.high.y - liver.low.y));
            score *= std::min(1.0, (kCavaFront - from_back) / kCavaDepth);
            if (score <= best_score) continue;
            best_score = score;
            best = Mask(g);
            for (const auto& [level, piece] : chain)
                for (const std::size_t o : *piece)
                    best.voxels[std::size_t(level) * slice + o] = 1;
        }
    }
    return trimSections(best);
}

// Finds the portal trunk and its branches: the piece of thick blood, at the liver's middle heights and away
// from the cava, that touches most of the vessels deep in the liver. Pieces are connected outside the cava's
// wall; voxels next to that wall are neither counted nor kept. Vessels near the surface are not counted,
// because a mask that is too large includes rims of cava and kidney.
Mask findPortalTrunk(const Scene& s, const Mask& cava) {
    const Grid& g = s.blood.grid;
    const FloatVolume to_cava = distanceTo(cava);
    Mask thick = dilated(eroded(s.blood, kTrunkRadius_m), kTrunkRadius_m);
    for (std::size_t i = 0; i < thick.voxels.size(); ++i) {
        const double height = s.height(g.voxelAt(i).z);
        if (height < kTrunkLow || height > kTrunkHigh || double(to_cava.voxels[i]) < kCavaWall_m)
            thick.voxels[i] = 0;
    }
    const FloatVolume to_deep = distanceTo(intersect(s.vessels, eroded(s.liver, kDeepInLiver_m)));
    const auto off_cava = [&](std::size_t o) { return double(to_cava.voxels[o]) >= kOffCava_m; };
    std::size_t highest = 0;
    Piece trunk;
    filterComponents(thick, [&](const Piece& piece) {
        const auto met = std::size_t(std::count_if(piece.begin(), piece.end(), [&](std::size_t o) {
            return off_cava(o) && double(to_deep.voxels[o]) < kNearVessels_m;
        }));
        if (met > highest) highest = met, trunk = piece;
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
    for (const VoxelPiece& piece : connectedPieces(vessels, set)) {
        const std::vector<double> r = lumenRadius_m(piece, wallDistance_m(piece));
        for (std::size_t m = 0; m < piece.size(); ++m)
            radius[piece.voxel(m)] = float(r[m]);
    }
    return radius;
}

constexpr std::uint8_t kPortal = 1, kHepatic = 2;

bool containsLabel(const Mask& seeds, std::uint8_t label) {
    return std::find(seeds.voxels.begin(), seeds.voxels.end(), label) != seeds.voxels.end();
}

// Cost of a path from a tree's seeds to each voxel, nearly the cheapest one: what a step costs depends on the
// path before it, and only one path to each voxel is kept. Away from its root, a tree's vessels become
// narrower. A path that leads into a wider vessel has probably entered the other tree, so it pays for the
// width. Outside the vessels it pays for the missing contrast.
std::vector<float> pathCost(const Scene& s, const FloatVolume& radius, const Mask& seeds,
                            std::uint8_t label) {
    std::vector<std::uint32_t> starts;
    for (std::uint32_t i = 0; i < seeds.voxels.size(); ++i)
        if (seeds.voxels[i] == label) starts.push_back(i);
    std::vector<float> narrowest_m(seeds.voxels.size(), std::numeric_limits<float>::infinity());
    const auto extend = [&](float cost, std::uint32_t from, std::uint32_t to, double step_m) {
        const double missing = 1.0 - double(s.contrast.voxels[to]);
        const double wide_m = std::max(kThinRadius_m, kWider * double(narrowest_m[from]));
        const double per_m =
            s.vessels.voxels[to]
                ? 1.0 + kWideningCost * std::max(0.0, double(radius.voxels[to]) / wide_m - 1.0)
                : 1.0 + kOutsideCost * missing * missing;
        return cost + float(step_m * per_m);
    };
    std::size_t left = countVoxels(s.vessels);
    return findCheapestPaths(seeds.grid, starts, extend,
                             [&](std::uint32_t voxel, const CheapestPaths& paths) {
                                 const std::uint32_t parent = paths.parent[voxel];
                                 float& narrowest = narrowest_m[voxel];
                                 if (parent != kNoVoxel) narrowest = narrowest_m[parent];
                                 if (s.vessels.voxels[voxel])
                                     narrowest = std::min(narrowest, radius.voxels[voxel]);
                                 left -= s.vessels.voxels[voxel] != 0;
                                 return left > 0;
                             })
        .cost;
}

// The middle of a tree's seeds: roughly where it begins.
Vec3 findRoot(const Mask& seeds, std::uint8_t label) {
    Vec3 sum{0.0};
    double count = 0.0;
    forEachVoxel(seeds.grid, [&](const Index3& i) {
        if (seeds[i] == label) sum += seeds.grid.centre(i), count += 1.0;
    });
    return sum / std::max(1.0, count);
}

// Whether the vessel runs rather towards the root of the hepatic veins (up to 1) or of the portal vein (down
// to -1): the share of the variance of the vessel voxels near `at` in the one direction, less that in the
// other.
double courseToHepatic(const Mask& vessels, const Index3& at, const Vec3& hepatic_m, const Vec3& portal_m) {
    const Grid& g = vessels.grid;
    const Vec3 centre = g.centre(at);
    const auto direction = [&](const Vec3& root_m) {
        const double length_m = glm::length(root_m - centre);
        return length_m > 0.0 ? (root_m - centre) / length_m : Vec3(0.0);
    };
    const Vec3 to_hepatic = direction(hepatic_m), to_portal = direction(portal_m);
    Vec3 sum{0.0};
    double count = 0.0, all = 0.0, hepatic = 0.0, portal = 0.0;
    forEachVoxel(boxAround(g, at, int(kCourseReach_m / g.spacing_m.x)), [&](const Index3& i) {
        const Vec3 d = g.spacing_m * Vec3(i - at);
        if (!vessels[i] || glm::length(d) > kCourseReach_m) return;
        const double h = glm::dot(d, to_hepatic), p = glm::dot(d, to_portal);
        sum += d, count += 1.0;
        all += glm::dot(d, d), hepatic += h * h, portal += p * p;
    });
    const auto variance = [&](double squares, double mean) { return squares / count - mean * mean; };
    const Vec3 mean = sum / count;
    const double total = variance(all, glm::length(mean));
    if (!(total > 0.0)) return 0.0;
    return (variance(hepatic, glm::dot(mean, to_hepatic)) - variance(portal, glm::dot(mean, to_portal))) /
           total;
}

// Returns the vessel voxels of the hepatic veins, by a minimum cut; the others are portal vein. A contact
// between the trees is narrower than a vessel, and the walls in it are darker than blood, so each face costs
// the cube of its contrast. The sixth power cut at noise instead. An additional factor for the distance to
// the wall changed little. The cut alone prefers small pieces near the seeds. So each voxel also prefers one
// of the trees for two reasons: the cheaper path comes from it, or the vessel runs towards its root.
Mask cutTrees(const Scene& s, const FloatVolume& radius, const Mask& seeds) {
    const Grid& g = seeds.grid;
    CutProblem problem{LabelVolume(g), FloatVolume(g), {}};
    const std::vector<float> to_portal = pathCost(s, radius, seeds, kPortal),
                             to_hepatic = pathCost(s, radius, seeds, kHepatic);
    const bool both = containsLabel(seeds, kPortal) && containsLabel(seeds, kHepatic);
    const Vec3 portal_m = findRoot(seeds, kPortal), hepatic_m = findRoot(seeds, kHepatic);
    parallelVoxels(g, [&](const Index3& at) {
        const std::size_t i = g.offset(at);
        if (seeds.voxels[i] == kHepatic) problem.state.voxels[i] = std::uint8_t(CutState::object);
        if (seeds.voxels[i] || !s.vessels.voxels[i]) return;
        problem.state.voxels[i] = std::uint8_t(CutState::free);
        const double nearer =
            std::log(kPortalFarther * (double(to_portal[i]) + kStep_m) / (double(to_hepatic[i]) + kStep_m));
        const double course = both ? courseToHepatic(s.vessels, at, hepatic_m, portal_m) : 0.0;
        problem.preference.voxels[i] = float(
            kCutUnits * g.spacing_m.x *
            (kPathWeight_per_m * std::clamp(nearer, -kMaxNearer, kMaxNearer) + kCourseWeight_per_m * course));
    });
    problem.link = [&](std::size_t a, std::size_t b) {
        if (!s.vessels.voxels[a] || !s.vessels.voxels[b]) return 0.0f;
        const float contrast = std::min(s.contrast.voxels[a], s.contrast.voxels[b]);
        return kCutUnits * std::max(kMinFaceCost, contrast * contrast * contrast);
    };
    return minimumCut(problem);
}

// Sets seeds with this label on the vessel voxels near a large vessel, above `min_height`.
void seedNear(const Scene& s, const Mask& large, std::uint8_t label, double min_height, Mask& seeds) {
    const FloatVolume to = distanceTo(large);
    for (std::size_t i = 0; i < seeds.voxels.size(); ++i)
        if (s.vessels.voxels[i] && double(to.voxels[i]) <= kJoin_m &&
            s.height(seeds.grid.voxelAt(i).z) >= min_height)
            seeds.voxels[i] = label;
}

// Fallback if no large vessel was found: sets seeds in the widest lumen between two heights of the liver.
// They fill its cross-section, because the cheapest way to cut off a single voxel is around it.
void seedWidest(const Scene& s, const FloatVolume& radius, double from, double to, std::uint8_t label,
                Mask& seeds) {
    const auto isCandidate = [&](std::size_t i) {
        const double height = s.height(seeds.grid.voxelAt(i).z);
        return height >= from && height < to && !seeds.voxels[i];
    };
    std::size_t best = 0;
    float widest = 0.0f;
    for (std::size_t i = 0; i < radius.voxels.size(); ++i)
        if (radius.voxels[i] > widest && isCandidate(i)) widest = radius.voxels[i], best = i;
    if (widest == 0.0f) return;
    seeds.voxels[best] = label;
    floodFaces(seeds.grid, {seeds.grid.voxelAt(best)}, [&](const Index3& i) {
        const std::size_t at = seeds.grid.offset(i);
        if (radius.voxels[at] < widest || !isCandidate(at)) return false;
        seeds.voxels[at] = label;
        return true;
    });
}

// Sets seeds on all lumen in the liver's upper part that is nearly as wide as the widest there. These are the
// stems of the hepatic veins, even if their connection to the cava was not found.
void seedStems(const Scene& s, const FloatVolume& radius, const Mask& cava, Mask& seeds) {
    const FloatVolume to_cava = distanceTo(cava);
    const bool found = countVoxels(cava) > 0;
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

// Returns the contrast of blood over parenchyma after the blur. It is the upper quartile of the voxels that
// are certainly vessel; 0 if there are none.
double bloodContrast(const TubeEvidence& e) {
    std::vector<float> values;
    for (std::size_t i = 0; i < e.liver.voxels.size(); ++i)
        if (e.liver.voxels[i] && e.score(i) > kCertainVessel) values.push_back(e.contrast_hu.voxels[i]);
    return double(lowerQuantile(std::move(values), 0.75));
}

// Maximum contrast of `inside` within kMiddle_m of each of its voxels.
FloatVolume centreContrast(const FloatVolume& contrast_hu, const Mask& inside) {
    const Grid& g = inside.grid;
    const int reach = int(kMiddle_m / g.spacing_m.x);
    FloatVolume out(g);
    parallelVoxels(g, [&](const Index3& at) {
        if (!inside[at]) return;
        float highest = contrast_hu[at];
        forEachVoxel(boxAround(g, at, reach), [&](const Index3& to) {
            if (inside[to] && glm::length(g.spacing_m * Vec3(to - at)) <= kMiddle_m)
                highest = std::max(highest, contrast_hu[to]);
        });
        out[at] = highest;
    });
    return out;
}

}  // namespace

FoundVessels findVessels(const CtVolume& ct, const Mask& liver) {
    if (countVoxels(liver) == 0) return {Mask(ct.grid), Mask(ct.grid)};
    const TubeEvidence e = tubeEvidence(ct, liver, TubeKind::bright, kVesselRadii_m);
    const Mask core = eroded(e.liver, kLiverRim_m);
    const double blood_hu = bloodContrast(e);
    if (blood_hu <= 0.0) return {Mask(ct.grid), Mask(ct.grid)};  // nothing is certain
    const double wider_m = std::max(0.0, ct.grid.spacing_m.x - kFine_m);
    const double min_score = std::max(kMinInside, kInsideVessel - kInsideLess_per_m * wider_m);
    const auto scoring = [&](double least, double level_share) {
        return maskWhere(e.liver.grid, [&](std::size_t i) {
            return e.liver.voxels[i] && double(e.score(i)) > least &&
                   double(e.contrast_hu.voxels[i]) > level_share * blood_hu &&
                   (core.voxels[i] || e.line.voxels[i] > kRimLine);
        });
    };
    Mask inside = scoring(min_score, kLevelShare);
    const Mask suspected = scoring(std::max(kMinSuspected, min_score - kSuspectedLess), kSuspectedShare);
    const FloatVolume middle = centreContrast(e.contrast_hu, inside);
    for (std::size_t i = 0; i < inside.voxels.size(); ++i)
        inside.voxels[i] = inside.voxels[i] && e.contrast_hu.voxels[i] > kWallShare * middle.voxels[i];
    const auto min_voxels = std::size_t(kMinVesselPiece_m3 / (1e-6 * voxelVolume_ml(ct.grid)));
    const Mask vessels = filterComponents(inside, [&](const Piece& piece) {
        return piece.size() >= min_voxels && std::any_of(piece.begin(), piece.end(), [&](std::size_t o) {
                   return e.score(o) > kCertainVessel;
               });
    });
    return {uncropped(vessels, e.box, ct.grid), uncropped(subtract(suspected, vessels), e.box, ct.grid)};
}

SplitVessels splitVessels(const CtVolume& ct, const Mask& liver, const Mask& vessels) {
    SplitVessels out{Mask(ct.grid), Mask(ct.grid), Mask(ct.grid), {}};
    if (countVoxels(vessels) == 0 || countVoxels(liver) == 0) {
        out.notes.push_back("No vessels show in the liver: the scan has too little contrast medium in them.");
        return out;
    }
    const Scene s = vesselScene(ct, liver, vessels);
    const FloatVolume radius = lumenRadius(s.vessels);
    const Mask cava = segmentCava(s);
    const Mask trunk = findPortalTrunk(s, cava);
    Mask seeds(s.vessels.grid);
    seedNear(s, trunk, kPortal, 0.0, seeds);
    seedNear(s, cava, kHepatic, kVeinsLow, seeds);
    seedStems(s, radius, cava, seeds);
    if (!containsLabel(seeds, kPortal)) {
        out.notes.push_back(
            "No portal trunk was found at the hilum: the portal vein begins at the widest vessel "
            "of the liver's middle.");
        seedWidest(s, radius, kTrunkLow, kTrunkHigh, kPortal, seeds);
    }
    if (!containsLabel(seeds, kHepatic)) {
        out.notes.push_back(
            "No cava was found behind the liver: the hepatic veins begin at the widest vessel "
            "of its upper part.");
        seedWidest(s, radius, kVeinsLow, 1.01, kHepatic, seeds);
    }
    if (!containsLabel(seeds, kPortal) && !containsLabel(seeds, kHepatic))
        seedWidest(s, radius, -kAnyHeight, kAnyHeight, kPortal, seeds);
    const Mask hepatic = cutTrees(s, radius, seeds);
    out.portal = uncropped(subtract(s.vessels, hepatic), s.box, ct.grid);
    out.hepatic = uncropped(hepatic, s.box, ct.grid);
    out.cava = uncropped(subtract(cava, s.vessels), s.box, ct.grid);
    return out;
}

}  // namespace stylet::modeller
