#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/modeller/build/accuracy.h"
#include "app/modeller/build/atlas.h"
#include "app/modeller/build/path_forces.h"
#include "app/modeller/commands.h"

namespace stylet::modeller {

namespace {

using patient::Label;
using patient::Package;
using patient::Tissue;

struct Options {
    std::string truth, found;
    std::size_t most_paths = 200;
};

struct Structure {
    std::string name;
    std::function<Mask(const Package&)> mask;  // on the package's own grid
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

// By name where both tables have it; by tissue where one merges what the other splits.
std::vector<Structure> structures() {
    std::vector<Structure> all{
        {"liver, whole", [](const Package& p) { return wholeLiver(p.labels, p.label_table); }},
        {"bone", [](const Package& p) {
             return labelled(p, [](const Label& l) {
                 return l.tissue == Tissue::bone && l.name != "cartilage and discs";
             });
         }}};
    for (const char* name :
         {"portal vein", "hepatic veins", "bile ducts", "right lung", "left lung", "fascia", "skin",
          "right kidney", "left kidney", "spleen", "heart", "aorta and arteries", "vena cava and renal veins",
          "gallbladder", "stomach and oesophagus", "colon", "spinal canal"})
        all.push_back({name, [name](const Package& p) {
                           return labelled(p, [name](const Label& l) { return l.name == name; });
                       }});
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

void runCompare(const Options& o) {
    const Package truth = patient::loadPackage(o.truth);
    Package found = patient::loadPackage(o.found);
    refuseItself(truth.name, found.provenance);
    found.motion = truth.motion;  // one breath for both
    const patient::Grid& grid = found.labels.grid;
    std::printf("%-26s %6s %9s %9s %9s %10s %10s\n", "structure", "Dice", "mean mm", "HD95 mm", "HD mm",
                "truth ml", "found ml");
    for (const Structure& s : structures()) {
        const Mask a = onGrid(s.mask(truth), grid);
        if (std::find(a.voxels.begin(), a.voxels.end(), 1) == a.voxels.end()) continue;
        const Agreement agreement = compare(a, onGrid(s.mask(found), grid));
        std::printf("%-26s %6.3f %9.2f %9.2f %9.2f %10.2f %10.2f\n", s.name.c_str(), agreement.dice,
                    1e3 * agreement.mean_surface_m, 1e3 * agreement.hausdorff95_m,
                    1e3 * agreement.hausdorff_m, agreement.truth_ml, agreement.found_ml);
    }
    const patient::Patient true_patient(truth), found_patient(found);
    std::vector<patient::PlannedPath> paths = patient::planPaths(true_patient, {}).paths;
    if (paths.size() > o.most_paths) paths.resize(o.most_paths);
    const PathForces f = compareForces(true_patient, found_patient, paths);
    if (f.paths == 0) {
        std::printf("no path can be planned in %s: no forces to compare\n", o.truth.c_str());
        return;
    }
    std::printf(
        "forces on %zu paths planned in the first: RMS error %.3f N, median path %.3f N, worst path "
        "%.3f N, largest %.2f N, %.1f %% of ticks equal\n",
        f.paths, f.rms_n, f.median_path_rms_n, f.worst_path_rms_n, f.largest_n, 100.0 * f.equal_share);
}

}  // namespace

void addCompare(CLI::App& app) {
    const auto o = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "compare", "how far a package's labels, and the forces on its paths, are from the truth");
    command->add_option("truth", o->truth, "package with the true labels")->required();
    command->add_option("found", o->found, "package to judge, of the same CT")->required();
    command->add_option("--paths", o->most_paths, "the best so many of the planned ones")
        ->capture_default_str();
    command->callback([o] { runCompare(*o); });
}

}  // namespace stylet::modeller
