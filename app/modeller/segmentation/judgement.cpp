#include "app/modeller/segmentation/judgement.h"

#include <algorithm>
#include <array>
#include <functional>

#include "app/modeller/image/morphology.h"
#include "app/modeller/import/import_map.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/atlas.h"
#include "base/traversal.h"

namespace stylet::modeller {

using patient::Label;
using patient::Package;
using patient::Tissue;

namespace {

constexpr float kBesidePath_m = 0.005f;

struct Structure {
    std::string name;
    std::function<bool(const Label&)> holds;
    bool in_liver = false;  // counted only inside the true liver
};

// Most structures are matched by label name. Bone and the vessels in the liver are matched by tissue, because
// one label table may merge labels that the other splits.
std::vector<Structure> structures() {
    const auto named = [](const char* name) { return [name](const Label& l) { return l.name == name; }; };
    const auto isVessel = [](const Label& l) { return l.tissue == Tissue::vessel; };
    std::vector<Structure> all{{"bone", isBone},
                               {"vessels in the liver", isVessel, true},
                               {"portal vein in it", named("portal vein"), true},
                               {"hepatic veins in it", named("hepatic veins"), true}};
    for (const char* name :
         {"bile ducts", "right lung", "left lung", "fascia", "skin", "right kidney", "left kidney", "spleen",
          "heart", "aorta and arteries", "vena cava and renal veins", "portal vein", "gallbladder",
          "stomach and oesophagus", "colon", "small bowel", "spinal canal"})
        all.push_back({name, named(name)});
    return all;
}

// Returns true for labels that a person drew or that are synthetic, not for those that an import's rules
// added.
bool isTruth(const Label& l) {
    return l.provenance.starts_with("manual") || l.provenance.starts_with("synthetic");
}

Mask labelled(const Package& p, const std::function<bool(const Label&)>& holds) {
    return labelMask(p.labels, p.label_table, holds);
}

Mask insideBody(const Package& p) {
    return maskWhere(p.ct.grid, [&](std::size_t i) { return p.ct.voxels[i] != kOutside_hu; });
}

// Returns the truth's grid, cropped to the heights of the found package and of the whole liver.
Grid comparedRegion(const Package& truth, const Mask& true_liver, const Package& found) {
    const Grid& g = truth.labels.grid;
    const auto clamped = [&](const Vec3& p) { return std::clamp(g.nearest(p).z, 0, g.dims.z - 1); };
    int low = clamped(found.labels.grid.origin_m),
        high = clamped(found.labels.grid.centre(found.labels.grid.dims - 1));
    if (const VoxelBox liver = boundingBox(true_liver); !liver.empty())
        low = std::min(low, liver.low.z), high = std::max(high, liver.high.z);
    return {{g.dims.x, g.dims.y, high - low + 1}, g.spacing_m, g.centre({0, 0, low})};
}

Mask onGrid(const Mask& mask, const Grid& grid) {
    Mask out(grid);
    parallelVoxels(grid, [&](const Index3& i) { out[i] = mask.nearestOr(grid.centre(i), 0); });
    return out;
}

// The voxels within kBesidePath_m of a planned path: the region reached by a needle and its deviations.
Mask besidePaths(const Grid& grid, const std::vector<patient::PlannedPath>& paths) {
    Mask on(grid);
    for (const patient::PlannedPath& path : paths)
        for (VoxelWalk walk(grid, path.entry_reference_m, path.target_reference_m); !walk.done(); walk.next())
            if (grid.contains(walk.voxel())) on[walk.voxel()] = 1;
    if (paths.empty()) return on;
    const FloatVolume distance = distanceTo(on);
    return maskWhere(grid, [&](std::size_t i) { return distance.voxels[i] <= kBesidePath_m; });
}

}  // namespace

std::vector<StructureAgreement> compareStructures(const Package& truth, const Package& found,
                                                  const std::vector<patient::PlannedPath>& paths) {
    const Mask whole = wholeLiver(truth.labels, truth.label_table);
    const Grid grid = comparedRegion(truth, whole, found);
    const Mask beside = besidePaths(grid, paths), liver = onGrid(whole, grid);
    const bool full = patient::isFullySegmented(truth);
    std::vector<StructureAgreement> all;
    if (full)
        all.push_back({"body", compare(onGrid(labelled(truth, [](const Label&) { return true; }), grid),
                                       onGrid(insideBody(found), grid), beside)});
    all.push_back(
        {"liver, whole", compare(liver, onGrid(wholeLiver(found.labels, found.label_table), grid), beside)});
    for (const Structure& s : structures()) {
        const auto& table = truth.label_table;
        if (std::any_of(table.begin(), table.end(),
                        [&](const Label& l) { return s.holds(l) && !isTruth(l); }))
            continue;
        Mask a = onGrid(labelled(truth, s.holds), grid), b = onGrid(labelled(found, s.holds), grid);
        if (s.in_liver) a = intersect(a, liver), b = intersect(b, liver);
        // If the truth is not fully segmented, a structure without a true label is not counted as an error.
        if (countVoxels(a) > 0 || (full && countVoxels(b) > 0))
            all.push_back({s.name, compare(a, b, beside)});
    }
    return all;
}

std::map<std::string, std::size_t> countRiskCrossings(const Package& truth,
                                                      const std::vector<patient::PlannedPath>& paths) {
    std::array<const Label*, 256> risks{};
    for (const Label& l : truth.label_table)
        if (l.role == patient::Role::risk) risks[l.id] = &l;
    std::map<std::string, std::size_t> crossed;
    const Grid& g = truth.labels.grid;
    for (const patient::PlannedPath& path : paths)
        for (VoxelWalk walk(g, path.entry_reference_m, path.target_reference_m); !walk.done(); walk.next()) {
            // An edge or corner is only touched.
            if (!g.contains(walk.voxel()) || walk.begin() == walk.end()) continue;
            const Label* const risk = risks[truth.labels[walk.voxel()]];
            if (!risk) continue;
            ++crossed[risk->name];
            break;
        }
    return crossed;
}

}  // namespace stylet::modeller
