#include "app/modeller/check/check_scan.h"

#include <algorithm>

#include "app/modeller/image/scan_blur.h"
#include "app/modeller/import/section.h"
#include "base/geodesic.h"
#include "base/statistics.h"

namespace stylet::modeller {

using enum Findings::Grade;
using patient::BloodKind;
using patient::Structure;

namespace {

constexpr double kFatInDuct_hu = -10.0;
// Depth below the outermost row within which a flank counts as flat.
constexpr double kFlat_m = 0.003;
constexpr Range kFlat_percent{0.0, 35.0};
// Contact of bone and liver that is reported, and that is refused. One side of a cube of 10 mm has 100 mm^2.
constexpr double kSomeContact_mm2 = 100.0, kMostContact_mm2 = 500.0;
// The smallest piece of bone inside the liver that is reported: a sphere of 6 mm.
constexpr double kPiece_mm3 = 100.0;

bool isParenchyma(const Label& l) {
    return l.tissue == Tissue::liver && l.structure != Structure::tumour;
}
bool isHepaticVessel(const Label& l) {
    return l.blood == BloodKind::portal || l.blood == BloodKind::hepatic ||
           (l.abdominal && l.tissue == Tissue::vessel && l.blood == BloodKind::other);
}
bool isDuct(const Label& l) {
    return l.tissue == Tissue::duct;
}
bool isFascia(const Label& l) {
    return l.tissue == Tissue::fascia;
}

Mask maskOf(const Package& p, bool (*wanted)(const Label&)) {
    return labelMask(p.labels, p.label_table, wanted);
}

// Counts duct voxels inside the liver: outside it, ducts are surrounded by fat. The mean over the duct voxels
// around each one removes most of the noise.
double fatInDucts(const Package& p, const Mask& ducts, const Mask& whole_liver) {
    constexpr double kInside = 20.0;  // of the 27 voxels around; 18 at a plane border
    double all = 0.0, fat = 0.0;
    forEachVoxel(p.ct.grid, [&](const Index3& i) {
        if (!ducts[i]) return;
        double sum = 0.0, count = 0.0, inside = 0.0;
        forEachVoxel(boxAround(p.ct.grid, i, 1), [&](const Index3& n) {
            inside += whole_liver[n];
            if (ducts[n]) sum += p.ct[n], ++count;
        });
        if (inside <= kInside) return;
        ++all, fat += sum / count < kFatInDuct_hu;
    });
    return fat / all;
}

// Outer air: connected to the image's sides through unlabelled air, and through fascia in air.
double fasciaOutside(const Package& p, const Mask& fascia) {
    const Grid& g = p.ct.grid;
    const Mask air = maskWhere(g, [&](std::size_t i) {
        return p.ct.voxels[i] < p.thresholds.t0_hu && (p.labels.voxels[i] == 0 || fascia.voxels[i]);
    });
    Mask sides(g);
    forEachVoxel(g, [&](const Index3& i) {
        sides[i] = air[i] && (i.x == 0 || i.y == 0 || i.x + 1 == g.dims.x || i.y + 1 == g.dims.y);
    });
    const Mask outside = floodFill(sides, air);
    double all = 0.0, out = 0.0;
    for (std::size_t i = 0; i < outside.voxels.size(); ++i)
        if (fascia.voxels[i]) ++all, out += outside.voxels[i];
    return out / all;
}

// Ribs are separated from the liver by fascia and diaphragm.
double boneAtLiver_mm2(const Package& p, const Mask& liver) {
    const Mask bone = maskOf(p, isBone);
    const Grid& g = p.labels.grid;
    const Vec3 mm = 1e3 * g.spacing_m;
    double area_mm2 = 0.0;
    forEachVoxel(g, [&](const Index3& i) {
        if (!bone[i]) return;
        for (const Index3& step : kFaceSteps)
            if (g.contains(i + step) && liver[i + step])
                area_mm2 += mm.x * mm.y * mm.z / glm::length(Vec3(step) * mm);
    });
    return area_mm2;
}

struct RibDistances {
    double median = std::nan(""), lower_quartile = std::nan("");
};

// Measures the distances between the middles of successive pieces of bone in columns of voxels along z. The
// rib cage is as wide as the columns with at least two pieces; an arm's bone is one piece. Only its outer
// quarters count, where no vertebrae are. Narrow gaps do not divide a piece: imported bone may be hollow.
RibDistances ribDistances(const PackageStatistics& m) {
    constexpr std::size_t kFewest = 50;
    constexpr double kMarrow = 0.03;  // widest gap, as a share of the bones' width: 8 mm in an adult
    constexpr double kFlanks = 0.25, kOutliers = 0.002, kQuartile = 0.25, kMedian = 0.5;
    const Mask bone = maskOf(m.package, isBone);
    const Grid& g = bone.grid;
    const VoxelBox box = boundingBox(bone);
    if (box.empty()) return {};
    const double marrow_m = kMarrow * (box.high.x - box.low.x) * g.spacing_m.x;
    struct Distance {
        int x;
        double m;
    };
    std::vector<Distance> all;
    std::vector<double> columns;  // x of each distance
    for (int y = box.low.y; y <= box.high.y; ++y)
        for (int x = box.low.x; x <= box.high.x; ++x) {
            double last_m = -1.0;
            int first = -1, end = -1;  // of the current piece
            const auto finish = [&] {
                const double middle_m = 0.5 * (first + end) * g.spacing_m.z;
                if (last_m >= 0.0) all.push_back({x, middle_m - last_m}), columns.push_back(x);
                last_m = middle_m;
            };
            for (int z = 0; z < g.dims.z; ++z) {
                if (!bone[{x, y, z}]) continue;
                if (first >= 0 && z - end > 1 && (z - end) * g.spacing_m.z > marrow_m) finish(), first = -1;
                if (first < 0) first = z;
                end = z;
            }
            if (first >= 0) finish();
        }
    if (all.size() < kFewest) return {};
    const double low_x = lowerQuantile(columns, kOutliers), high_x = lowerQuantile(columns, 1.0 - kOutliers);
    const double flank = kFlanks * (high_x - low_x), width_m = (high_x - low_x) * g.spacing_m.x;
    std::vector<double> shares;
    for (const Distance& d : all)
        if ((d.x >= low_x && d.x <= low_x + flank) || (d.x <= high_x && d.x >= high_x - flank))
            shares.push_back(d.m / width_m);
    if (shares.size() < kFewest || width_m <= 0.0) return {};
    return {lowerQuantile(shares, kMedian), lowerQuantile(shares, kQuartile)};
}

// Volume of the pieces that lie inside the liver and are connected to no rib or vertebra: bone, and
// unlabelled or liver voxels with the CT value of bone.
double boneInLiver_mm3(const PackageStatistics& m) {
    const Package& p = m.package;
    const Mask dense = maskWhere(p.labels.grid, [&](std::size_t i) {
        const Label* const l = m.patient.label(p.labels.voxels[i]);
        if (l && l->tissue != Tissue::liver) return isSkeleton(l->tissue);
        return p.ct.voxels[i] >= p.thresholds.t2_specific_hu;
    });
    const Components pieces =
        findComponents(surroundedPieces(dense, maskOf(p, isWholeLiver)), Connectivity::corners);
    double sum_mm3 = 0.0;
    for (const std::size_t voxels : pieces.size)
        if (const double volume_mm3 = 1e3 * double(voxels) * m.voxel_ml(); volume_mm3 > kPiece_mm3)
            sum_mm3 += volume_mm3;
    return sum_mm3;
}

constexpr const char* kPortalSeries =
    ". Use the series of the portal venous phase, 60 to 80 s after the injection";

// Vessels' share of the liver's volume. In a portal venous phase it is above kUsualVessels. A patient with
// less than kFewVessels is refused.
constexpr double kUsualVessels = 0.015, kFewVessels = 0.006;

// What the scan seems to be if it is not of the portal venous phase, and what to do; empty if it is. A build
// finds no aorta without contrast medium, nor one that is as bright as bone. It may take noise for vessels of
// the liver.
std::string wrongPhase(const ScanMeasures& s) {
    const char* phase = nullptr;
    const auto showsVessels = [&](double share) {
        return s.vessels_hu - s.liver_hu >= 25.0 && s.vessel_share >= share;
    };
    if (s.aorta_hu > 220.0 && !showsVessels(kFewVessels))
        phase = "an arterial phase";
    else if (s.aorta_hu < 80.0)
        phase = "a scan without contrast medium";
    else if (std::isnan(s.aorta_hu) && s.liver_hu < 85.0 && !showsVessels(kUsualVessels))
        phase = "a scan without contrast medium, or an arterial phase";
    else if (s.aorta_hu < 135.0)
        phase = "a late phase, or little contrast medium";
    return phase ? "it looks like " + std::string(phase) + kPortalSeries : "";
}

void checkContrast(const ScanMeasures& s, bool has_ducts, Findings& f) {
    const std::string phase = wrongPhase(s);
    const std::string no_vessels = "no path is rated by its risk of bleeding; " +
                                   (phase.empty() ? "the vessels are not labelled or not visible" : phase);
    if (std::isnan(s.vessels_hu)) {
        f.expect(has_ducts ? refused : warned, "vessels in the liver", 0.0, "% of it", {0.6, kUnbounded},
                 no_vessels);
        return;
    }
    const double contrast_hu = s.vessels_hu - s.liver_hu;
    f.expect(contrast_hu < 12.0 ? refused : warned, "vessels brighter than the liver", contrast_hu, "HU",
             {25.0, kUnbounded},
             "30 to 60 in the portal venous phase (Foley 1989), else vessels are lost; " +
                 (phase.empty() ? "use a series with more contrast medium" : phase));
    f.expect(s.vessel_share < (phase.empty() ? kFewVessels : kUsualVessels) ? refused : warned,
             "vessels in the liver", 100.0 * s.vessel_share, "% of it", {100.0 * kUsualVessels, kUnbounded},
             phase.empty()
                 ? "thin or noisy vessels were lost. Use a series with smoother slices, or correct the "
                   "stage vessels"
                 : "most vessels were lost; " + phase);
    // The labels themselves may look right.
    if (!phase.empty() && !std::isnan(s.aorta_hu) && contrast_hu >= 25.0 && s.vessel_share >= kUsualVessels)
        f.add(warned, "contrast phase",
              fmt::format("aorta {:.0f} HU, liver {:.0f} HU", s.aorta_hu, s.liver_hu), "portal venous",
              phase);
}

void checkNoise(const ScanMeasures& s, Findings& f) {
    if (std::isnan(s.noise_hu)) return;
    f.expect(
        warned, "noise in the liver", s.noise_hu, "HU", {0.0, 18.0},
        "8 to 15 in a diagnostic scan: thin vessels, ducts and fascia are lost in it. Use a series with a "
        "soft kernel or thicker slices");
}

// Measured in slices of 3 mm: 1.6 mm, of 5 mm: 2.06 mm, where 6 to 9 % of the paths ended at false bone
// before bones were smoothed. Wide voxels blur too, and other checks are about those. If no blur can be
// measured, the distance between slices is checked.
void checkSlices(const ScanMeasures& s, double slice_m, double voxel_m, Findings& f) {
    constexpr double kThick_m = 0.00175, kThickest_m = 0.0019, kFarthest_m = 0.0041;
    if (std::isnan(s.blur_across_m)) {
        f.expect(refused, "distance of slices", 1e3 * slice_m, "mm", {0.0, 1e3 * kFarthest_m},
                 "no lung on a diaphragm shows their blur. Borders of ribs are inaccurate, and a needle is "
                 "stopped beside them. Use a series with thinner slices");
        return;
    }
    f.expect(s.blur_across_m > std::max(kThickest_m, voxel_m) ? refused : warned, "blur across slices",
             1e3 * s.blur_across_m, "mm", {0.0, 1e3 * std::max(kThick_m, voxel_m)},
             "0.5 to 1.6 in slices of up to 3 mm: these are thicker, or the diaphragm moved. Borders of ribs "
             "are inaccurate, and a needle is stopped beside them. Use a series with thinner slices, in a "
             "breath-hold");
}

// In a reference patient with 1.12 mm (seed 513, soft-kernel), the liver was 39 ml too large, most of it
// diaphragm, and beside planned paths its border was 0.8 mm off. The usual blur is 0.7 to 0.8 mm.
void checkKernel(double blur_within_m, double voxel_m, Findings& f) {
    f.expect(warned, "blur within slices", 1e3 * blur_within_m, "mm",
             {0.0, 1e3 * std::max(kHidesDiaphragm_m, voxel_m)},
             "the fat between liver and diaphragm is blurred away, and the liver may take in the diaphragm: "
             "inspect the liver, or use a series with a sharper kernel");
}

struct Organ {
    const char* name;
    bool (*wanted)(const Label&);
    int side;  // -1: left of the body's middle, +1: right
};
constexpr Organ kOrgans[] = {
    {"right kidney", [](const Label& l) { return l.structure == Structure::kidney; }, 1},
    {"left kidney", [](const Label& l) { return l.structure == Structure::kidney; }, -1},
    {"spleen", [](const Label& l) { return l.structure == Structure::spleen; }, -1}};

void checkOrgans(const PackageStatistics& m, Findings& f) {
    const double middle_m = m.body_centre_sum.x / m.body_voxels;
    for (const Organ& organ : kOrgans) {
        const PackageStatistics::Sum s = m.sum([&](const Label& l) {
            return organ.wanted(l) && (m.centre_sum[l.id].x / m.voxels[l.id] > middle_m) == (organ.side > 0);
        });
        f.expect(
            warned, organ.name, s.voxels * m.voxel_ml(), "ml", {25.0, kUnbounded},
            "it is missing: removed, outside of the scan, or not recognised. Paths do not avoid it. Correct "
            "the stage organs, or map its label");
    }
}

// Few rows of a round flank end near its outermost one: 19 % within 3 mm on an ellipse 340 mm wide. A scan
// that cuts the flank ends all rows in one plane, also if air was added beyond it. Counts the share of a
// plane of voxels that lies within kFlat_m; the outermost plane counts whole.
double flatShare(const PackageStatistics& m, bool right) {
    const Grid& g = m.package.ct.grid;
    std::vector<int> ends;
    for (int z = 0; z < g.dims.z; ++z)
        for (int y = 0; y < g.dims.y; ++y) {
            int x = right ? g.dims.x - 1 : 0;
            while (x >= 0 && x < g.dims.x && !m.inBody({x, y, z}))
                x += right ? -1 : 1;
            if (x >= 0 && x < g.dims.x) ends.push_back(right ? x : -x);
        }
    if (ends.empty()) return 0.0;
    const int outermost = *std::max_element(ends.begin(), ends.end());
    const double planes = kFlat_m / g.spacing_m.x;
    double flat = 0.0;
    for (const int end : ends)
        flat += end == outermost ? 1.0 : std::clamp(planes - (outermost - end), 0.0, 1.0);
    return flat / double(ends.size());
}

// In percent of the rib cage's width, because a child's ribs are closer. The median is 10.5 to 11.8 in
// reference patients and 14 to 33 in a real patient and its deformations (imported, built); with half the
// distance of the slices, 5.9 to 6.3 and 9.1 to 9.3. Missing ribs raise it, but not the lower quartile: 9.7
// to 10.8 and 7.8 to 18.5; with twice the distance, 19.5 to 21.7 and 10 (imported) or 21.5 (built). Between
// the limits the cause is uncertain. A factor of 1.5 is seldom noticed.
void checkRibDistance(const ScanMeasures& s, Findings& f) {
    constexpr double kClose = 9.5, kTooClose = 8.0, kFar = 19.0, kTooFar = 24.0;
    const double median = 100.0 * s.rib_distance_median, quartile = 100.0 * s.rib_distance_quartile;
    if (std::isnan(median)) return;
    const char* const what = "distance of ribs above one another";
    const char* const unit = "% of the rib cage's width";
    const std::string wrong = "the file states a wrong distance of its slices, or ",
                      cure = ". Correct ImagePositionPatient, or in a NIfTI file pixdim and srow";
    f.expect(median < kTooClose ? refused : warned, what, median, unit, {kClose, kUnbounded},
             wrong + "what lies between ribs was taken for bone" + cure);
    f.expect(quartile > kTooFar ? refused : warned, what, quartile, unit, {-kUnbounded, kFar},
             wrong + "most ribs are missing" + cure);
}

// Cartilage has 22 % of the bones' volume in reference patients and up to 14 % in what is built; a person may
// draw all of it. It had 89 % where kidneys and vessels were taken for bone and half of the liver for
// cartilage.
void checkCartilage(const ScanMeasures& s, Findings& f) {
    constexpr double kMuch_percent = 50.0, kTooMuch_percent = 75.0;
    const double percent = 100.0 * s.cartilage_share;
    if (std::isnan(percent)) return;
    f.expect(
        percent > kTooMuch_percent ? refused : warned, "cartilage", percent, "% of the bones' volume",
        {0.0, kMuch_percent},
        "part of an organ is labelled as cartilage, which resists a needle more. Inspect bones and fascia: "
        "vessels or kidneys as bright as bone may be labelled as bone. Correct the stage bones, or the map");
}

void checkFlanks(const ScanMeasures& s, Findings& f) {
    const char* const cure =
        "the field of view cuts the body: there is no skin. Reconstruct the scan with a wider field of view";
    f.expect(refused, "right flank in one plane", 100.0 * s.flat_right, "% of its rows, 3 mm deep",
             kFlat_percent, cure);
    f.expect(warned, "left flank in one plane", 100.0 * s.flat_left, "% of its rows, 3 mm deep",
             kFlat_percent, cure);
}

// The vessels with parenchyma around them. The trunk of the portal vein says nothing about those in the
// liver.
PackageStatistics::Sum vesselsInLiver(const Package& p) {
    constexpr double kReach_m = 0.008;
    constexpr float kSurrounding = 0.15f;  // minimum share of parenchyma within this distance
    const Mask vessels = maskOf(p, isHepaticVessel);
    const FloatVolume around = boxMean(toFloat(maskOf(p, isParenchyma)),
                                       std::max(1, int(std::lround(kReach_m / p.ct.grid.spacing_m.x))));
    PackageStatistics::Sum sum;
    for (std::size_t i = 0; i < vessels.voxels.size(); ++i)
        if (vessels.voxels[i] && around.voxels[i] > kSurrounding)
            sum.voxels += 1.0, sum.hu += double(p.ct.voxels[i]);
    return sum;
}

}  // namespace

ScanMeasures measureScan(const PackageStatistics& m) {
    const Package& p = m.package;
    const auto mean = [](const PackageStatistics::Sum& s) {
        return s.voxels > 0.0 ? s.mean_hu() : std::nan("");
    };
    const PackageStatistics::Sum vessels = vesselsInLiver(p);
    ScanMeasures s;
    s.liver_hu = mean(m.sum(isParenchyma));
    s.vessels_hu = mean(vessels);
    s.aorta_hu = mean(m.sum([](const Label& l) { return l.blood == BloodKind::artery; }));
    s.noise_hu = measureNoise_hu(p.ct, maskOf(p, isParenchyma));
    s.blur_across_m = measureBlurAcross(p.ct).value_or(std::nan(""));
    s.vessel_share = vessels.voxels / m.sum(isWholeLiver).voxels;
    s.fat_in_ducts = fatInDucts(p, maskOf(p, isDuct), maskOf(p, isWholeLiver));
    s.flat_right = flatShare(m, true), s.flat_left = flatShare(m, false);
    s.bone_at_liver_mm2 =
        boneAtLiver_mm2(p, maskOf(p, [](const Label& l) { return l.tissue == Tissue::liver; }));
    s.bone_in_liver_mm3 = boneInLiver_mm3(m);
    if (const double bone = m.sum(Tissue::bone).voxels; bone > 0.0)
        s.cartilage_share = m.sum(Tissue::cartilage).voxels / bone;
    const RibDistances ribs = ribDistances(m);
    s.rib_distance_median = ribs.median, s.rib_distance_quartile = ribs.lower_quartile;
    s.fascia_outside = fasciaOutside(p, maskOf(p, isFascia));
    return s;
}

void checkScan(const PackageStatistics& m, Findings& f) {
    const ScanMeasures s = measureScan(m);
    const Vec3 voxel_m = m.package.ct.grid.spacing_m;
    checkContrast(s, m.sum(isDuct).voxels > 0.0, f);
    checkRibDistance(s, f);
    checkFlanks(s, f);
    checkNoise(s, f);
    checkSlices(s, m.package.scan.slice_m, voxel_m.z, f);
    checkKernel(m.package.scan.blur_within_m, voxel_m.x, f);
    checkOrgans(m, f);
    f.expect(s.bone_at_liver_mm2 > kMostContact_mm2 ? refused : warned, "bone at the liver",
             s.bone_at_liver_mm2, "mm^2 of contact", {0.0, kSomeContact_mm2},
             "a calcification was taken for bone, or a rib for liver: a needle would be stopped there. "
             "Correct the stage bones");
    checkCartilage(s, f);
    f.expect(warned, "bone inside the liver", s.bone_in_liver_mm3, "mm^3", {0.0, kPiece_mm3},
             "no rib is connected to it: a calcified tumour, a stone or a stent. Labelled as bone it stops a "
             "needle and may bend the fascia; labelled as liver it does not. Correct the stage bones or the "
             "map, and look at the fascia");
    if (!std::isnan(s.fascia_outside))
        f.expect(refused, "fascia outside the body", 100.0 * s.fascia_outside, "% of it", {0.0, 1.0},
                 "it left the body: ribs are missing or calcifications were taken for ribs. Edit the control "
                 "points of the stage fascia");
    if (!std::isnan(s.fat_in_ducts))
        f.expect(s.fat_in_ducts > 0.3 ? refused : warned, "ducts in fat", 100.0 * s.fat_in_ducts,
                 "% of their voxels", {0.0, 10.0},
                 "bile has 0 to 20 HU: fat in a fissure of the liver was taken for ducts. Correct the stage "
                 "ducts");
}

}  // namespace stylet::modeller
