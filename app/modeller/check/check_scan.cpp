#include "app/modeller/check/check_scan.h"

#include <algorithm>

#include "app/modeller/import/section.h"

namespace stylet::modeller {

using enum Findings::Grade;
using patient::BloodKind;
using patient::Structure;

namespace {

constexpr double kNoiseLag_m = 0.004;
constexpr double kFatInDuct_hu = -10.0;

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

// The median of absolute differences is robust against vessels and lesions.
double noise(const Package& p, const Mask& liver) {
    const Grid& g = p.ct.grid;
    const int lag = std::max(2, int(std::lround(kNoiseLag_m / g.spacing_m.x)));
    std::vector<int> differences;
    forEachVoxel(g, [&](const Index3& i) {
        if (i.x + lag < g.dims.x && liver[i] && liver[i + Index3{lag, 0, 0}])
            differences.push_back(std::abs(p.ct[i] - p.ct[i + Index3{lag, 0, 0}]));
    });
    if (differences.empty()) return std::nan("");
    const auto middle = differences.begin() + std::ptrdiff_t(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    return *middle / (0.6745 * std::sqrt(2.0));
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

// Which phase the scan seems to show, for the reason of a finding.
std::string phaseOf(const ScanMeasures& s) {
    if (s.aorta_hu > 220.0) return "an arterial phase";
    if (s.aorta_hu < 80.0 || (std::isnan(s.aorta_hu) && s.liver_hu < 80.0))
        return "a scan without contrast medium";
    return "a late phase, or little contrast medium";
}

void checkContrast(const ScanMeasures& s, bool has_ducts, Findings& f) {
    const std::string cure = ", it looks like " + phaseOf(s) +
                             ". Use the series of the portal venous phase, 60 to 80 s after the injection";
    const double contrast_hu = s.vessels_hu - s.liver_hu;
    if (std::isnan(s.vessels_hu)) {
        f.expect(
            has_ducts ? refused : warned, "vessels in the liver", 0.0, "% of it", {0.6, kUnbounded},
            "no path is rated by its risk of bleeding: the vessels are not labelled or not visible" + cure);
        return;
    }
    f.expect(refused, "vessels brighter than the liver", contrast_hu, "HU", {12.0, kUnbounded},
             "30 to 60 in the portal venous phase (Foley 1989): vessel labels are unreliable" + cure);
    f.expect(warned, "vessels brighter than the liver", contrast_hu, "HU", {25.0, kUnbounded},
             "30 to 60 in the portal venous phase (Foley 1989): thin vessels are lost" + cure);
    f.expect(
        s.vessel_share < 0.006 ? refused : warned, "vessels in the liver", 100.0 * s.vessel_share, "% of it",
        {1.5, kUnbounded},
        "too few: thin or noisy vessels were lost. Use a series with thicker or smoother slices, or correct "
        "the vessels by hand");
}

void checkNoise(const ScanMeasures& s, Findings& f) {
    if (std::isnan(s.noise_hu)) return;
    f.expect(
        warned, "noise in the liver", s.noise_hu, "HU", {0.0, 18.0},
        "8 to 15 in a diagnostic scan: thin vessels, ducts and fascia are lost in it. Use a series with a "
        "soft kernel or thicker slices");
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

}  // namespace

ScanMeasures measureScan(const PackageStatistics& m) {
    const Package& p = m.package;
    const auto mean = [](const PackageStatistics::Sum& s) {
        return s.voxels > 0.0 ? s.mean_hu() : std::nan("");
    };
    const PackageStatistics::Sum vessels = m.sum(isHepaticVessel);
    ScanMeasures s;
    s.liver_hu = mean(m.sum(isParenchyma));
    s.vessels_hu = mean(vessels);
    s.aorta_hu = mean(m.sum([](const Label& l) { return l.blood == BloodKind::artery; }));
    s.noise_hu = noise(p, maskOf(p, isParenchyma));
    s.vessel_share = vessels.voxels / m.sum(isWholeLiver).voxels;
    s.fat_in_ducts = fatInDucts(p, maskOf(p, isDuct), maskOf(p, isWholeLiver));
    s.fascia_outside = fasciaOutside(p, maskOf(p, isFascia));
    return s;
}

void checkScan(const PackageStatistics& m, Findings& f) {
    const ScanMeasures s = measureScan(m);
    checkContrast(s, m.sum(isDuct).voxels > 0.0, f);
    checkNoise(s, f);
    checkOrgans(m, f);
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
