#include "app/modeller/build/judgement.h"

#include <algorithm>
#include <array>
#include <functional>

#include "app/modeller/build/atlas.h"
#include "app/modeller/build/morphology.h"
#include "app/modeller/section.h"

namespace stylet::modeller {

using patient::Label;
using patient::Package;
using patient::Tissue;

namespace {

constexpr float kBesidePath_m = 0.005f;

struct Structure {
    std::string name;
    std::function<Mask(const Package&)> mask;  // on the package's own grid
    bool in_liver = false;                     // counted inside the true liver only
};

Mask labelled(const Package& p, const std::function<bool(const Label&)>& holds) {
    std::array<std::uint8_t, 256> in{};
    for (const Label& l : p.label_table)
        in[l.id] = holds(l);
    Mask mask(p.labels.grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        mask.voxels[i] = in[p.labels.voxels[i]];
    return mask;
}

// Where labels are few, what an import or a build left of the CT.
Mask body(const Package& p) {
    if (patient::isFullySegmented(p)) return labelled(p, [](const Label&) { return true; });
    Mask mask(p.ct.grid);
    for (std::size_t i = 0; i < mask.voxels.size(); ++i)
        mask.voxels[i] = p.ct.voxels[i] != kOutside_hu;
    return mask;
}

// By name where both tables have it; by tissue where one merges what the other splits.
std::vector<Structure> structures() {
    std::vector<Structure> all{
        {"body", body},
        {"liver, whole", [](const Package& p) { return wholeLiver(p.labels, p.label_table); }},
        {"bone", [](const Package& p) {
             return labelled(p, [](const Label& l) {
                 return l.tissue == Tissue::bone && l.name != "cartilage and discs";
             });
         }}};
    const auto named = [](const char* name) {
        return [name](const Package& p) {
            return labelled(p, [name](const Label& l) { return l.name == name; });
        };
    };
    all.push_back({"vessels in the liver",
                   [](const Package& p) {
                       return labelled(p, [](const Label& l) { return l.tissue == Tissue::vessel; });
                   },
                   true});
    for (const char* name : {"portal vein", "hepatic veins"})
        all.push_back({std::string(name) + " in it", named(name), true});
    for (const char* name :
         {"bile ducts", "right lung", "left lung", "fascia", "skin", "right kidney", "left kidney", "spleen",
          "heart", "aorta and arteries", "vena cava and renal veins", "gallbladder", "stomach and oesophagus",
          "colon", "spinal canal"})
        all.push_back({name, named(name)});
    return all;
}

Mask onGrid(const Mask& mask, const patient::Grid& grid) {
    Mask out(grid);
    forEachSlab(grid.dims.z, [&](int z) {
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x)
                out[{x, y, z}] = mask.nearestOr(grid.centre({x, y, z}), 0);
    });
    return out;
}

// What lies within kBesidePath_m of a planned path: what a needle and its deviations meet.
Mask besidePaths(const patient::Grid& grid, const std::vector<patient::PlannedPath>& paths) {
    Mask on(grid);
    for (const patient::PlannedPath& path : paths)
        for (patient::VoxelWalk walk(grid, path.entry_reference_m, path.target_reference_m); !walk.done();
             walk.next())
            if (grid.contains(walk.voxel())) on[walk.voxel()] = 1;
    if (paths.empty()) return on;
    const FloatVolume distance = distanceTo(on);
    for (std::size_t i = 0; i < on.voxels.size(); ++i)
        on.voxels[i] = distance.voxels[i] <= kBesidePath_m;
    return on;
}

}  // namespace

std::vector<Judged> judge(const Package& truth, const Package& found,
                          const std::vector<patient::PlannedPath>& paths) {
    const patient::Grid& grid = found.labels.grid;
    const Mask beside = besidePaths(grid, paths),
               liver = onGrid(wholeLiver(truth.labels, truth.label_table), grid);
    std::vector<Judged> all;
    for (const Structure& s : structures()) {
        Mask a = onGrid(s.mask(truth), grid), b = onGrid(s.mask(found), grid);
        if (s.in_liver) a = both(a, liver), b = both(b, liver);
        if (countOf(a) > 0) all.push_back({s.name, compare(a, b, beside)});
    }
    return all;
}

}  // namespace stylet::modeller
