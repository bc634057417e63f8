#include "app/modeller/check/check_package.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "app/modeller/check/check_scan.h"
#include "app/modeller/import/section.h"
#include "base/parallel.h"
#include "base/traversal.h"
#include "patient/motion/motion_interface.h"
#include "patient/package/motion_io.h"
#include "patient/planning/planning.h"

namespace stylet::modeller {

using enum Findings::Grade;

namespace {

// Sampling for checkFascia(), which tests straight lines from the skin to the liver. Entry points on the skin
// are kEntrySpacing_m apart, target points in the liver kTargetSpacing_m. Lines longer than a needle
// (NeedleShape's default) are skipped. This gives about 250,000 lines, enough to detect a hole of 3 x 3 mm in
// the fascia.
constexpr double kEntrySpacing_m = 0.012, kTargetSpacing_m = 0.020;

std::string formatCount(double count) {
    return std::to_string(std::llround(count));
}

void checkGrid(const Grid& g, Findings& f) {
    const char* const axes[] = {"voxel size in x", "voxel size in y", "voxel size in z"};
    for (int d = 0; d < 3; ++d) {
        const double mm = 1e3 * g.spacing_m[d];
        if (!(mm >= 0.3 && mm <= 5.0))
            f.expect(refused, axes[d], mm, "mm", {0.3, 5.0},
                     "coarser voxels lose the fascia and the ducts, finer ones do not fit into memory");
        else
            f.expect(warned, axes[d], mm, "mm", {0.3, 2.5}, "a dilated duct is 3 mm wide");
    }
}

// Checks the force table for every tissue that can occur in the patient, either through a label or through
// the HU thresholds. Also checks the order of the thresholds.
void checkTissues(const PackageStatistics& m, Findings& f) {
    std::array<bool, patient::kTissueCount> is_used{};
    for (const Tissue t : {Tissue::skin, Tissue::soft, Tissue::bone})
        is_used[std::size_t(t)] = true;
    for (const Label& l : m.package.label_table)
        is_used[std::size_t(l.tissue)] = true;
    is_used[std::size_t(Tissue::air)] = false;
    for (int t = 0; t < patient::kTissueCount; ++t) {
        if (!is_used[std::size_t(t)]) continue;
        const patient::TissueRow& row = m.package.tissues[std::size_t(t)];
        const std::string name = "tissue " + std::string(tissueName(Tissue(t)));
        f.expect(refused, name + ", stiffness_n_per_m", row.stiffness_n_per_m, "N/m", {1.0, 1e6},
                 "without a stiffness nothing is felt");
        f.expect(refused, name + ", cut_force_n", row.cut_force_n, "N", {0.01, kUnbounded},
                 "without a cutting force the needle meets no resistance");
        f.expect(refused, name + ", young_pa", m.package.elasticity[std::size_t(t)].young_pa, "Pa",
                 {10.0, kUnbounded}, "without an elasticity it cannot be palpated");
    }
    const patient::Thresholds& t = m.package.thresholds;
    const char* const why = "air < t0 <= skin < t1 <= soft < t2 <= bone, and past the fascia t2 is no lower";
    f.expect(refused, "threshold t1 above t0", t.t1_hu - t.t0_hu, "HU", {1.0, kUnbounded}, why);
    f.expect(refused, "threshold t2 above t1", t.t2_sensitive_hu - t.t1_hu, "HU", {1.0, kUnbounded}, why);
    f.expect(refused, "threshold t2 past the fascia, above the one outside",
             t.t2_specific_hu - t.t2_sensitive_hu, "HU", {0.0, kUnbounded}, why);
}

void checkLabels(const PackageStatistics& m, Findings& f) {
    for (int id = 1; id < 256; ++id)
        if (m.voxels[std::size_t(id)] > 0.0 && !m.patient.label(std::uint8_t(id)))
            f.add(refused, "label " + std::to_string(id),
                  formatCount(m.voxels[std::size_t(id)]) + " voxels without an entry in the label table",
                  "none", "its tissue is unknown");
}

// Checks the structures that a puncture needs.
void checkStructures(const PackageStatistics& m, Findings& f) {
    const auto expectPresent = [&](Findings::Grade grade, const std::string& what, double voxels,
                                   const char* why) {
        f.expect(grade, what, voxels * m.voxel_ml(), "ml", {m.voxel_ml(), kUnbounded}, why);
    };
    expectPresent(refused, "skin", m.sum(Tissue::skin).voxels, "a needle begins at the skin");
    expectPresent(refused, "liver", m.sum(Tissue::liver).voxels,
                  "without a liver there is nothing to puncture");
    expectPresent(refused, "fascia", m.sum(Tissue::fascia).voxels,
                  "it is felt, and other thresholds apply behind it");
    const double right = m.lung(true).voxels, left = m.lung(false).voxels;
    if (right + left == 0.0) {
        expectPresent(refused, "lungs", 0.0,
                      "they lie in the way of a puncture between the ribs, and are its risk");
    } else {
        expectPresent(warned, "right lung", right, "it lies in the way of a puncture between the ribs");
        expectPresent(warned, "left lung", left, "one lung alone is a rare finding");
    }
    expectPresent(warned, "bone", m.sum(Tissue::bone).voxels,
                  "where no rib is labelled, thresholds alone decide");
    expectPresent(warned, "vessels", m.sum(Tissue::vessel).voxels,
                  "without them no path is rated by its risk of bleeding");
}

void checkValues(const PackageStatistics& m, Findings& f) {
    const auto mean = [&](Findings::Grade grade, const std::string& what, const PackageStatistics::Sum& s,
                          Range range, const char* why) {
        if (s.voxels > 0.0) f.expect(grade, "mean of " + what, s.mean_hu(), "HU", range, why);
    };
    mean(refused, "liver", m.sum(Tissue::liver), {-20.0, 180.0},
         "59 +- 11 without contrast medium (Boyce et al. 2010), less with fat in it, 100 to 120 with medium "
         "(Bae 2010); else the labels or the values are wrong");
    mean(refused, "bone", m.sum(Tissue::bone), {100.0, 1000.0},
         "marrow 80 to 200, cortex above 700 (Schreiber et al. 2011); else the labels or the values are "
         "wrong");
    mean(refused, "lungs", m.sum(isLung), {-960.0, -400.0},
         "-850 to -750 (Gevenois et al. 1996), denser where ill; else the labels or the values are wrong");
    const PackageStatistics::Sum blood = m.sum(Tissue::vessel);
    mean(warned, "vessels", blood, {20.0, 500.0}, "blood 40 without contrast medium, 300 to 400 in arteries");
    if (blood.voxels > 0.0)
        f.expect(warned, "threshold of bone past the fascia", m.package.thresholds.t2_specific_hu, "HU",
                 {blood.mean_hu(), kUnbounded},
                 "the vessels' mean: an unlabelled vessel would be felt as bone");
}

// Checks the positions of liver, lungs and spine relative to each other and to the body. Wrong positions show
// that the image is mirrored or turned against the RAS axes.
void checkPositions(const PackageStatistics& m, Findings& f) {
    const Vec3 liver = m.sum(Tissue::liver).centre();
    f.expect(refused, "liver to the right of the body's middle",
             1e3 * (liver.x - m.body_centre_sum.x / m.body_voxels), "mm", {0.0, kUnbounded},
             "the image is mirrored (or a situs inversus, which is not supported)");
    const PackageStatistics::Sum lungs = m.sum(isLung);
    if (lungs.voxels > 0.0)
        f.expect(refused, "lungs above the liver", 1e3 * (lungs.centre().z - liver.z), "mm",
                 {0.0, kUnbounded}, "the image is upside down");
    const PackageStatistics::Sum spine = m.sum([](const Label& l) {
        return l.structure == patient::Structure::spine || l.structure == patient::Structure::spinal_canal;
    });
    if (spine.voxels > 0.0)
        f.expect(refused, "liver in front of the spine", 1e3 * (liver.y - spine.centre().y), "mm",
                 {0.0, kUnbounded}, "front and back are exchanged");
}

Mask packageMask(const Package& p, bool (*wanted)(const Label&)) {
    return labelMask(p.labels, p.label_table, wanted);
}

void checkCropping(const Mask& liver, Findings& f) {
    const Grid& g = liver.grid;
    double sides = 0.0;
    std::vector<double> slices(std::size_t(g.dims.z), 0.0);
    forEachVoxel(g, [&](const Index3& i) {
        if (!liver[i]) return;
        ++slices[std::size_t(i.z)];
        sides += i.x == 0 || i.y == 0 || i.x + 1 == g.dims.x || i.y + 1 == g.dims.y;
    });
    const double most = *std::max_element(slices.begin(), slices.end());
    const auto cut = [&](const char* what, double slice) {
        const double share = 100.0 * slice / most;
        if (share > 10.0)
            f.expect(refused, what, share, "%", {0.0, 10.0},
                     "of the liver's largest slice: the image is cropped through the liver");
        else
            f.expect(warned, what, share, "%", {0.0, 0.0},
                     "of the liver's largest slice: the image ends here, or the label has leaked");
    };
    cut("liver in the lowest slice", slices.front());
    cut("liver in the highest slice", slices.back());
    f.expect(refused, "liver at the image's sides", sides, "voxels", {0.0, 0.0},
             "the image is cropped through the liver");
}

void checkLiver(const PackageStatistics& m, Findings& f) {
    const double voxels = m.sum(isWholeLiver).voxels;
    f.expect(refused, "liver volume", voxels * m.voxel_ml(), "ml", {600.0, 3500.0},
             "594 to 2250 in 369 healthy adults (Feng et al. 2017), 2022 +- 749 in men with cysts (Hogan et "
             "al. 2015); smaller in a child, else a part is missing or it has leaked");
    Mask whole = packageMask(m.package, isWholeLiver);
    f.expect(warned, "liver beside its largest piece", 100.0 * double(keepLargestComponent(whole)) / voxels,
             "%", {0.0, 5.0}, "a liver is in one piece");
    checkCropping(packageMask(m.package, [](const Label& l) { return l.tissue == Tissue::liver; }), f);
}

// Checks that there is air around the body, where the needle starts.
void checkFieldOfView(const PackageStatistics& m, Findings& f) {
    const Grid& g = m.package.labels.grid;
    const char* const names[] = {"left", "right", "back", "front"};
    double all = 0.0, cut = 0.0;
    for (int side = 0; side < 4; ++side) {
        const int axis = side / 2, along = 1 - axis;
        double touching = 0.0;
        for (int z = 0; z < g.dims.z; ++z)
            for (int a = 0; a < g.dims[along]; ++a) {
                Index3 i{0, 0, z};
                i[along] = a;
                i[axis] = side % 2 == 0 ? 0 : g.dims[axis] - 1;
                touching += m.inBody(i);
            }
        const double face = double(g.dims[along]) * g.dims.z;
        all += face, cut += touching;
        f.expect(warned, "body at the image's " + std::string(names[side]) + " side", 100.0 * touching / face,
                 "%", {0.0, 1.0}, "the scan cuts the body: no skin there");
    }
    f.expect(refused, "body at the image's four sides", 100.0 * cut / all, "%", {0.0, 80.0},
             "there is hardly any air left for a needle to come through");
}

// Voxels of the mask, about `apart_m` apart.
std::vector<Index3> sampleSparsely(const Mask& mask, double apart_m) {
    const Grid& g = mask.grid;
    const Index3 step = glm::max(Index3(Vec3(apart_m) / g.spacing_m), Index3(1));
    Mask taken(Grid{(g.dims + step - 1) / step, g.spacing_m, g.origin_m});
    std::vector<Index3> out;
    forEachVoxel(g, [&](const Index3& i) {
        if (!mask[i] || taken[i / step]) return;
        taken[i / step] = 1;
        out.push_back(i);
    });
    return out;
}

// Returns true if a straight needle reaches the liver without passing fascia, bone or cartilage.
bool missesFascia(const PackageStatistics& m, const Index3& entry, const Index3& target) {
    const Grid& g = m.package.labels.grid;
    for (VoxelWalk walk(g, g.centre(entry), g.centre(target)); !walk.done(); walk.next()) {
        const Tissue t = m.patient.at(walk.voxel(), {}).tissue;
        if (t == Tissue::fascia || isSkeleton(t)) return false;
        if (t == Tissue::liver) return true;
    }
    return false;
}

void checkFascia(const PackageStatistics& m, Findings& f) {
    const Package& p = m.package;
    const Mask skin = packageMask(p, [](const Label& l) { return l.tissue == Tissue::skin; });
    const Mask liver = packageMask(p, [](const Label& l) { return l.tissue == Tissue::liver; });
    const Mask fascia = packageMask(p, [](const Label& l) { return l.tissue == Tissue::fascia; });
    const Mask reached = floodFill(skin, inverted(fascia));
    std::size_t leaked = 0;
    for (std::size_t i = 0; i < liver.voxels.size(); ++i)
        leaked += liver.voxels[i] && reached.voxels[i];
    // If every path from the skin to the liver, however bent, passes fascia voxels, every straight line does
    // too.
    if (leaked == 0) return;
    const std::vector<Index3> entries = sampleSparsely(skin, kEntrySpacing_m),
                              targets = sampleSparsely(liver, kTargetSpacing_m);
    std::vector<std::size_t> through(entries.size(), 0), tried(entries.size(), 0);
    parallelFor(processorCount(), int(entries.size()), [&](int e) {
        const Index3 entry = entries[std::size_t(e)];
        for (const Index3& target : targets) {
            if (glm::length(Vec3(target - entry) * p.labels.grid.spacing_m) > NeedleShape().length_m)
                continue;
            ++tried[std::size_t(e)];
            through[std::size_t(e)] += missesFascia(m, entry, target);
        }
    });
    double hits = 0.0, all = 0.0;
    for (std::size_t e = 0; e < entries.size(); ++e)
        hits += double(through[e]), all += double(tried[e]);
    if (hits > 0.0)
        f.add(refused, "fascia",
              formatCount(hits) + " of " + formatCount(all) + " straight lines from skin to liver miss it",
              "none", "it is open: a needle would pass it without any force");
    else
        f.add(warned, "fascia", "the liver is reached around it, by no straight line of " + formatCount(all),
              "closed", "it has a hole or ends within the image");
}

void checkMotion(const patient::MotionModel& motion, Findings& f) {
    if (motion.empty()) {
        f.add(warned, "motion", "none", "a model", "the patient does not breathe");
        return;
    }
    try {
        patient::checkMotion("motion.nii.gz", motion);
    } catch (const DataError& e) {
        f.add(refused, "motion", e.what(), "a smooth one",
              "steeper, the tissue folds over itself; no such package is saved or loaded");
        return;
    }
    f.expect(refused, "least Jacobian of the motion", minJacobian(motion, 1.0), "", {1e-3, kUnbounded},
             "where it is not above 0 the tissue folds over itself");
    f.expect(warned, "travel of the diaphragm's dome", 1e3 * motion.dome_travel_m, "mm", {3.0, 40.0},
             "7 to 28 at rest (Keall et al. 2006, table I)");
}

void checkPaths(const PackageStatistics& m, int threads, Findings& f) {
    const double ducts_ml = m.sum(Tissue::duct).voxels * m.voxel_ml();
    if (ducts_ml == 0.0) {
        f.add(warned, "bile ducts", "none", "some",
              "there is no training path; build --virtual-ducts and import --grow-ducts grow some");
        return;
    }
    patient::PlanSettings settings;
    settings.threads = threads;
    const patient::PlanResult plan = planPaths(m.patient, settings);
    if (plan.paths.empty())
        f.add(
            warned, "planned paths",
            fmt::format(
                "none of {} lines from the right flank to {:.4g} ml of ducts ({} blocked, {} too long, "
                "{} too poor)",
                plan.candidates, ducts_ml, plan.rejected_blocked, plan.rejected_long, plan.rejected_quality),
            "at least one", "the ducts are out of reach: there is no training path");
}

}  // namespace

std::vector<Finding> checkPackage(const Package& package, int threads) {
    Findings f;
    const Grid& g = package.ct.grid;
    if (package.ct.voxels.empty() || package.ct.voxels.size() != g.voxelCount() ||
        package.labels.voxels.size() != g.voxelCount() || !(package.labels.grid == g)) {
        f.add(refused, "image", "CT and labels differ in size, or are empty", "one grid",
              "nothing can be measured");
        return f.list;
    }
    const PackageStatistics m(package);
    checkGrid(package.labels.grid, f);
    checkLabels(m, f);
    checkTissues(m, f);
    checkStructures(m, f);
    checkValues(m, f);
    checkMotion(package.motion, f);
    checkFieldOfView(m, f);
    if (m.sum(Tissue::liver).voxels > 0.0) {
        checkPositions(m, f);
        checkLiver(m, f);
        checkScan(m, f);
        if (m.sum(Tissue::skin).voxels > 0.0 && m.sum(Tissue::fascia).voxels > 0.0) checkFascia(m, f);
        if (!anyRefused(f.list)) checkPaths(m, threads, f);
    }
    std::vector<Finding> worst_first;
    for (const bool stops : {true, false})
        std::copy_if(f.list.begin(), f.list.end(), std::back_inserter(worst_first),
                     [stops](const Finding& x) { return x.refused == stops; });
    return worst_first;
}

bool anyRefused(const std::vector<Finding>& findings) {
    return std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.refused; });
}

std::string formatFinding(const Finding& f) {
    return (f.refused ? "REFUSED  " : "look     ") + f.what + ": " + f.value + ", expected " + f.expected +
           " (" + f.reason + ")";
}

}  // namespace stylet::modeller
