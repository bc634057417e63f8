// Finds aorta and vena cava as paths through the slices along which a disc of contrast medium is most
// visible. The path is found by dynamic programming from feet to head.
// Cf. Wink, Niessen and Viergever, "Multiscale vessel tracking", IEEE TMI 23, 2004 (minimum cost over a
// measure of centredness). The portal vein is grown instead, and renal veins are cheapest paths.
#include <algorithm>
#include <cmath>

#include "app/modeller/image/cheapest_paths.h"
#include "app/modeller/image/morphology.h"
#include "app/modeller/segmentation/organ_scene.h"
#include "base/statistics.h"

namespace stylet::modeller {

namespace {

constexpr double kMaxBlood_hu = 450.0;  // denser is bone or metal
constexpr double kAround_hu = 55.0;     // soft tissue around vessels
constexpr double kCavaAbove_hu = 15.0;  // minimum of cava and renal veins above the liver

// Where to look for the lumen's rim around a voxel that is `radius_m` from it.
double reachOfLumen(float radius_m) {
    return 1.2 * double(radius_m) + 0.002;
}

// Expected position of a vessel relative to the canal; metres.
struct Span {
    double low, typical, high;
};
struct Course {
    std::string name;
    Span x, y;
    double min_radius_m, max_radius_m;  // radius of the lumen
    double above_hu;                    // minimum HU above the liver's
    double confidence;                  // if it is seen in all slices
};

// Distance to the nearest voxel that is not blood, within each slice.
FloatVolume inPlaneRadii(const Mask& blood) {
    Mask apart = inverted(blood);
    constexpr double kFar_m = 900.0;  // keeps slices independent of each other
    apart.grid.spacing_m.z = kFar_m;
    FloatVolume d = distanceTo(apart);
    d.grid = blood.grid;
    return d;
}

struct SearchWindow {
    int x0 = 0, y0 = 0, nx = 0, ny = 0;
};

SearchWindow findSearchWindow(const OrganScene& s, const Course& c) {
    double x_low = 1e9, x_high = -1e9, y_low = 1e9, y_high = -1e9;
    for (const Vec3& p : s.canal) {
        x_low = std::min(x_low, p.x + c.x.low), x_high = std::max(x_high, p.x + c.x.high);
        y_low = std::min(y_low, p.y + c.y.low), y_high = std::max(y_high, p.y + c.y.high);
    }
    const Index3 a = glm::max(s.grid.nearest({x_low, y_low, 0.0}), Index3(0));
    const Index3 b = glm::min(s.grid.nearest({x_high, y_high, 0.0}), s.grid.dims - 1);
    return {a.x, a.y, std::max(b.x - a.x + 1, 0), std::max(b.y - a.y + 1, 0)};
}

// Scores a voxel by the radius of the lumen in millimetres, reduced away from the usual position. 0 outside
// the allowed range.
float scoreVoxel(const OrganScene& s, const Course& c, const FloatVolume& width, const Index3& i) {
    const double r = double(width[i]);
    if (r < c.min_radius_m || r > c.max_radius_m) return 0.0f;
    const Vec3 d = s.fromCanal(i);
    if (d.x < c.x.low || d.x > c.x.high || d.y < c.y.low || d.y > c.y.high) return 0.0f;
    const double off_x = (d.x - c.x.typical) / 0.030, off_y = (d.y - c.y.typical) / 0.040;
    return float(1e3 * std::min(r, 0.012) * std::max(0.1, 1.0 - 0.4 * (off_x * off_x + off_y * off_y)));
}

// A voxel in each slice (none if the search window is empty), and the sum of their scores minus the cost of
// sideward steps.
struct VesselPath {
    std::vector<Index3> voxels;
    double score = 0.0;
};

VesselPath findBestPath(const OrganScene& s, const Course& c, const FloatVolume& width) {
    const SearchWindow w = findSearchWindow(s, c);
    const int slices = s.grid.dims.z;
    const std::size_t n = std::size_t(w.nx) * std::size_t(w.ny);
    if (n == 0) return {};
    const int reach = std::max(1, int(std::lround(s.grid.spacing_m.z / s.grid.spacing_m.x)));
    const float per_step = float(0.6e3 * s.grid.spacing_m.x);
    std::vector<float> sum(n, 0.0f), last;
    std::vector<std::vector<std::int32_t>> from(static_cast<std::size_t>(slices),
                                                std::vector<std::int32_t>(n, 0));
    for (int z = 0; z < slices; ++z) {
        last = sum;
        for (int y = 0; y < w.ny; ++y)
            for (int x = 0; x < w.nx; ++x) {
                const std::size_t at = std::size_t(y * w.nx + x);
                float best = -1.0f;
                for (int dy = -reach; dy <= reach; ++dy)
                    for (int dx = -reach; dx <= reach; ++dx) {
                        const int xx = x + dx, yy = y + dy;
                        if (xx < 0 || yy < 0 || xx >= w.nx || yy >= w.ny) continue;
                        const float v =
                            last[std::size_t(yy * w.nx + xx)] - per_step * float(std::abs(dx) + std::abs(dy));
                        if (v > best || (dx == 0 && dy == 0 && v >= best))
                            best = v, from[std::size_t(z)][at] = yy * w.nx + xx;
                    }
                sum[at] = std::max(best, 0.0f) + scoreVoxel(s, c, width, {w.x0 + x, w.y0 + y, z});
            }
    }
    VesselPath path{std::vector<Index3>(static_cast<std::size_t>(slices), Index3(0)), 0.0};
    const auto best = std::max_element(sum.begin(), sum.end());
    path.score = double(*best);
    auto at = std::int32_t(best - sum.begin());
    for (int z = slices - 1; z >= 0; --z) {
        path.voxels[std::size_t(z)] = {w.x0 + at % w.nx, w.y0 + at / w.nx, z};
        at = from[std::size_t(z)][std::size_t(at)];
    }
    return path;
}

struct TrackedVessel {
    FoundOrgan organ;
    double score = 0.0;  // of the path; 0 if the vessel was not found
};

TrackedVessel trackVessel(const OrganScene& s, const Course& c, const Mask& within) {
    constexpr double kShare = 0.35;
    const Mask blood = inRange(s.edgeHu(), within, s.parenchyma_hu + c.above_hu, kMaxBlood_hu);
    const FloatVolume width = inPlaneRadii(blood);
    const auto [path, score] = findBestPath(s, c, width);
    TrackedVessel tracked{{c.name, Mask(s.grid), 0.0, ""}, 0.0};
    FoundOrgan& out = tracked.organ;
    std::vector<double> hu;
    for (const Index3& i : path)
        if (scoreVoxel(s, c, width, i) > 0.0f) hu.push_back(double(s.edgeHu()[i]));
    const double found_share = path.empty() ? 0.0 : double(hu.size()) / double(path.size());
    if (found_share < kShare) {
        out.note = c.name + ": no vessel with contrast medium runs along the spine";
        return tracked;
    }
    // The vessel's rim is where the HU is halfway between its centre and soft tissue. Where the vessel is
    // hardly visible, its smallest radius is assumed.
    const double rim_hu = 0.5 * (upperMedian(std::move(hu)) + kAround_hu);
    const auto shows = [&](const Index3& i) { return scoreVoxel(s, c, width, i) > 0.0f; };
    const auto first = std::find_if(path.begin(), path.end(), shows);
    const auto last = std::find_if(path.rbegin(), path.rend(), shows).base();
    for (auto it = first; it != last; ++it) {
        const Index3 i = *it;
        const double r_m = shows(i) ? reachOfLumen(width[i]) : c.min_radius_m;
        const int reach = int(std::ceil(r_m / s.grid.spacing_m.x));
        for (int dy = -reach; dy <= reach; ++dy)
            for (int dx = -reach; dx <= reach; ++dx) {
                const Index3 at = i + Index3(dx, dy, 0);
                if (!s.grid.contains(at) || !within[at]) continue;
                const double d = std::hypot(dx * s.grid.spacing_m.x, dy * s.grid.spacing_m.y);
                if (d <= r_m && double(s.edgeHu()[at]) > rim_hu) out.mask[at] = 1;
            }
    }
    removeSmallComponents(out.mask, 0.3, Connectivity::corners);
    if (countVoxels(out.mask) == 0) return tracked;
    tracked.score = score;
    out.confidence = c.confidence * found_share;
    if (found_share < 0.8) out.note = c.name + ": seen in parts of its way only";
    return tracked;
}

}  // namespace

GreatVessels findGreatVessels(const OrganScene& s) {
    const Course aorta{.name = "aorta and arteries",
                       .x = {-0.045, -0.012, 0.022},
                       .y = {0.018, 0.048, 0.085},
                       .min_radius_m = 0.0045,
                       .max_radius_m = 0.020,
                       .above_hu = 25.0,
                       .confidence = 0.9};
    const Course cava{.name = "vena cava and renal veins",
                      .x = {-0.008, 0.020, 0.052},
                      .y = {0.018, 0.055, 0.105},
                      .min_radius_m = 0.003,
                      .max_radius_m = 0.018,
                      .above_hu = kCavaAbove_hu,
                      .confidence = 0.65};  // some renal veins and the part below them are missed
    // Behind the liver, the cava may have been labelled as liver.
    const Mask around_cava = unite(s.free, s.liver);
    const auto apartFrom = [&](const Mask& within, const TrackedVessel& vessel) {
        return subtract(within, dilated(vessel.organ.mask, s.grid.spacing_m.x));
    };
    // The first fascia is uncertain beside the spine and may cut the aorta. Searched that far, less of the
    // cava was found in a deformed real patient.
    TrackedVessel aorta_first = trackVessel(s, aorta, s.free_wide);
    TrackedVessel cava_second = trackVessel(s, cava, apartFrom(around_cava, aorta_first));
    // Below the aorta's fork, that path of the aorta may continue in the cava. Then more of both is found if
    // the cava is found first. The aorta must be the same vessel: a cava without medium does not show, and
    // its path follows the aorta.
    TrackedVessel cava_first = trackVessel(s, cava, around_cava);
    TrackedVessel aorta_second = trackVessel(s, aorta, apartFrom(s.free_wide, cava_first));
    const bool same_aorta = 2 * countVoxels(intersect(aorta_first.organ.mask, aorta_second.organ.mask)) >
                            countVoxels(aorta_first.organ.mask);
    const bool finds_more = cava_first.score + aorta_second.score > aorta_first.score + cava_second.score;
    GreatVessels out = same_aorta && finds_more
                           ? GreatVessels{std::move(aorta_second.organ), std::move(cava_first.organ)}
                           : GreatVessels{std::move(aorta_first.organ), std::move(cava_second.organ)};
    out.cava.mask = intersect(out.cava.mask, s.free);
    if (countVoxels(out.cava.mask) == 0) out.cava.confidence = 0.0;
    return out;
}

// The portal vein runs across the slices. It is grown from its part in the liver.
FoundOrgan findExtrahepaticPortalVein(const OrganScene& s, double length_m) {
    constexpr double kNear_m = 0.006;
    constexpr double kArtery_m = 0.0015, kBowel_m = 0.010;  // radii: thinner is an artery, thicker is bowel
    constexpr double kMinContrast_hu = 15.0;                // above the liver
    constexpr double kMin_ml = 0.5, kConfidence = 0.6;      // parts of its course are missed
    FoundOrgan out{"portal vein", {}, 0.0, "portal vein: none is known in the liver to start from"};
    std::vector<double> hu;
    for (std::size_t i = 0; i < s.portal.voxels.size(); ++i)
        if (s.portal.voxels[i]) hu.push_back(double(s.edgeHu().voxels[i]));
    if (double(hu.size()) * voxelVolume_ml(s.grid) < kMin_ml) return out;
    out.note = "portal vein: its trunk is not seen outside the liver";
    const double contrast_hu = upperMedian(std::move(hu)) - s.parenchyma_hu;
    if (contrast_hu < kMinContrast_hu) return out;
    const double rim_hu = s.parenchyma_hu + 0.5 * contrast_hu;
    const Mask blood = inRange(s.edgeHu(), s.free, rim_hu, kMaxBlood_hu);
    const double voxel_m = s.grid.spacing_m.x;
    const Mask wide = intersect(blood, dilated(eroded(blood, kArtery_m), kArtery_m + voxel_m));
    const Mask tubes = subtract(wide, dilated(eroded(wide, kBowel_m), kBowel_m + 2.0 * voxel_m));
    out.mask = growWithin(intersect(tubes, dilated(s.portal, kNear_m)), tubes, length_m);
    removeSmallComponents(out.mask, kMin_ml, Connectivity::corners);
    if (countVoxels(out.mask) > 0) out.confidence = kConfidence, out.note.clear();
    return out;
}

namespace {

// Finds the cheapest path through blood from the cava to the kidney's hilum. Returns nothing if it is no
// vein.
std::vector<Index3> traceRenalVein(const OrganScene& s, const Mask& passable, const Mask& kidney,
                                   const Mask& cava, double cava_hu) {
    // A metre without contrast costs as much as 1 + kDarkCost metres of blood. In a real patient and a
    // deformed copy, the Dice of the veins falls by .01 to .02 with 10, and by 0 to .03 with 40.
    constexpr double kDarkCost = 20.0;
    // Share of the kidney's height around its middle. The splenic vein passes the left kidney's upper half.
    constexpr double kHilum = 0.4;
    // Mean contrast of a path. In a real patient, and in deformed copies of it, it is 0.84 to 0.99 along true
    // veins. In two reference patients it is 0.73 and 0.76 along the right vein, and up to 0.67 beside the
    // left. From 0.65 to 0.85 the Dice of a real patient, a deformed copy and two reference patients is the
    // same within .005; from 80 to 150 mm that of the first two is the same.
    constexpr double kMinContrast = 0.75, kMinLength_m = 0.005, kMaxLength_m = 0.110;
    constexpr double kMaxCost_m = kMaxLength_m * (1.0 + kDarkCost * (1.0 - kMinContrast));  // ends the search
    const Grid& g = s.grid;
    const auto contrast = [&](std::size_t i) {
        const double share = (double(s.edgeHu().voxels[i]) - s.parenchyma_hu) /
                             std::max(kCavaAbove_hu, cava_hu - s.parenchyma_hu);
        return std::clamp(share, 0.0, 1.0);
    };
    const double beside_m = 1.5 * g.spacing_m.x;
    const Mask start = intersect(passable, dilated(cava, beside_m)),
               beside_kidney = dilated(kidney, beside_m);
    std::vector<std::uint32_t> seeds;
    for (std::size_t i = 0; i < start.voxels.size(); ++i)
        if (start.voxels[i]) seeds.push_back(std::uint32_t(i));
    const VoxelBox box = boundingBox(kidney);
    const Vec3 middle = 0.5 * Vec3(box.low + box.high);
    const auto isHilum = [&](std::uint32_t at) {
        if (!beside_kidney.voxels[at]) return false;
        const Index3 i = g.voxelAt(at);
        const double canal_x = g.nearest(s.canal[std::size_t(i.z)]).x;
        const bool medial = std::fabs(i.x - canal_x) < std::fabs(middle.x - canal_x);
        return medial && std::fabs(i.z - middle.z) <= 0.5 * kHilum * (box.high.z - box.low.z);
    };
    std::uint32_t end = kNoVoxel;
    const CheapestPaths paths = findCheapestPaths(
        g, seeds,
        [&](float cost, std::uint32_t, std::uint32_t to, double step_m) {
            if (!passable.voxels[to]) return std::numeric_limits<float>::infinity();
            return cost + float(step_m * (1.0 + kDarkCost * (1.0 - contrast(to))));
        },
        [&](std::uint32_t at, const CheapestPaths& found) {
            if (isHilum(at)) end = at;
            return end == kNoVoxel && double(found.cost[at]) < kMaxCost_m;
        });
    std::vector<Index3> course;
    double length_m = 0.0, sum = 0.0;
    for (std::uint32_t at = end; at != kNoVoxel; at = paths.parent[at]) {
        const Index3 here = g.voxelAt(at);
        if (!course.empty()) length_m += glm::length(g.spacing_m * Vec3(here - course.back()));
        course.push_back(here), sum += contrast(at);
    }
    const bool is_vein =
        length_m > kMinLength_m && length_m < kMaxLength_m && sum > kMinContrast * double(course.size());
    return is_vein ? course : std::vector<Index3>();
}

// The lumen around a vessel's course, within `passable`.
Mask lumenAround(const OrganScene& s, const Mask& passable, const std::vector<Index3>& course) {
    constexpr double kMaxRadius_m = 0.007;  // 5 and 10 mm: the same within .002
    Mask lumen(s.grid);
    if (course.empty()) return lumen;
    std::vector<double> hu;
    for (const Index3& i : course)
        hu.push_back(double(s.edgeHu()[i]));
    const double rim_hu =
        std::max(s.parenchyma_hu + kCavaAbove_hu, 0.5 * (upperMedian(std::move(hu)) + kAround_hu));
    const Mask blood = inRange(s.edgeHu(), passable, rim_hu, kMaxBlood_hu);
    const FloatVolume radius = distanceTo(inverted(blood));
    for (const Index3& middle : course) {
        const double r_m = std::min(kMaxRadius_m, reachOfLumen(radius[middle]));
        forEachVoxel(boxAround(s.grid, middle, int(std::ceil(r_m / s.grid.spacing_m.x))),
                     [&](const Index3& i) {
                         if (blood[i] && glm::length(s.grid.spacing_m * Vec3(i - middle)) <= r_m)
                             lumen[i] = 1;
                     });
    }
    return lumen;
}

}  // namespace

// A renal vein runs across the slices and bends, so it is traced as a path.
Mask findRenalVeins(const OrganScene& s, const Mask& kidney_right, const Mask& kidney_left,
                    const Mask& cava) {
    // The path may not enter the portal vein within this distance of the liver: the left renal vein may touch
    // it. With 50 mm, the veins of a real patient are the same, but in two reference patients a path enters
    // the splenic vein.
    constexpr double kPortal_m = 0.070;
    constexpr double kAboveCava_hu = 90.0;  // brighter is medium in the bowel; 60 and 150: the same
    Mask veins(s.grid);
    std::vector<double> hu;
    for (std::size_t i = 0; i < cava.voxels.size(); ++i)
        if (cava.voxels[i]) hu.push_back(double(s.edgeHu().voxels[i]));
    if (hu.empty()) return veins;
    const double cava_hu = upperMedian(std::move(hu));
    Mask passable = maskWhere(s.grid, [&](std::size_t i) {
        return s.free.voxels[i] && double(s.edgeHu().voxels[i]) < cava_hu + kAboveCava_hu;
    });
    if (const Mask portal = findExtrahepaticPortalVein(s, kPortal_m).mask; !portal.voxels.empty())
        passable = subtract(passable, portal);
    for (const Mask* kidney : {&kidney_right, &kidney_left})
        if (countVoxels(*kidney) > 0)
            veins =
                unite(veins, lumenAround(s, passable, traceRenalVein(s, passable, *kidney, cava, cava_hu)));
    return veins;
}

}  // namespace stylet::modeller
