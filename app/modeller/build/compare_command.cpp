#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <memory>

#include "app/modeller/build/accuracy.h"
#include "app/modeller/build/path_forces.h"
#include "app/modeller/commands.h"

namespace stylet::modeller {

namespace {

using patient::Label;
using patient::LabelVolume;
using patient::Package;
using patient::Tissue;

struct Options {
    std::string truth, found;
    std::size_t most_paths = 200;
};

struct Structure {
    const char* name;
    std::function<bool(const Label&)> holds;
};

// Compared by name where both tables can have it; by tissue where one may have merged what the other split.
const Structure kStructures[] = {
    {"liver, whole", [](const Label& l) { return l.tissue == Tissue::liver || l.name == "cyst"; }},
    {"portal vein", [](const Label& l) { return l.name == "portal vein"; }},
    {"hepatic veins", [](const Label& l) { return l.name == "hepatic veins"; }},
    {"bile ducts", [](const Label& l) { return l.tissue == Tissue::duct; }},
    {"bone", [](const Label& l) { return l.tissue == Tissue::bone && l.name != "cartilage and discs"; }},
    {"right lung", [](const Label& l) { return l.name == "right lung"; }},
    {"left lung", [](const Label& l) { return l.name == "left lung"; }},
    {"fascia", [](const Label& l) { return l.tissue == Tissue::fascia; }},
    {"skin", [](const Label& l) { return l.tissue == Tissue::skin; }},
    {"right kidney", [](const Label& l) { return l.name == "right kidney"; }},
    {"left kidney", [](const Label& l) { return l.name == "left kidney"; }},
    {"spleen", [](const Label& l) { return l.name == "spleen"; }},
    {"heart", [](const Label& l) { return l.name == "heart"; }},
    {"aorta and arteries", [](const Label& l) { return l.name == "aorta and arteries"; }},
    {"gallbladder", [](const Label& l) { return l.name == "gallbladder"; }},
    {"stomach and oesophagus", [](const Label& l) { return l.name == "stomach and oesophagus"; }},
    {"colon", [](const Label& l) { return l.name == "colon"; }},
};

Mask maskIn(const Package& p, const patient::Grid& grid, const std::function<bool(const Label&)>& holds) {
    std::array<std::uint8_t, 256> in{};
    for (const Label& l : p.label_table)
        in[l.id] = holds(l);
    Mask mask(grid);
    forEachSlab(grid.dims.z, [&](int z) {
        for (int y = 0; y < grid.dims.y; ++y)
            for (int x = 0; x < grid.dims.x; ++x)
                mask[{x, y, z}] = in[p.labels.nearestOr(grid.centre({x, y, z}), 0)];
    });
    return mask;
}

void runCompare(const Options& o) {
    const Package truth = patient::loadPackage(o.truth);
    Package found = patient::loadPackage(o.found);
    found.motion = truth.motion;  // one breath for both
    const patient::Grid& grid = found.labels.grid;
    std::printf("%-24s %6s %9s %9s %9s %10s %10s\n", "structure", "Dice", "mean mm", "HD95 mm", "HD mm",
                "truth ml", "found ml");
    for (const Structure& s : kStructures) {
        const Mask a = maskIn(truth, grid, s.holds);
        if (std::find(a.voxels.begin(), a.voxels.end(), 1) == a.voxels.end()) continue;
        const Agreement agreement = compare(a, maskIn(found, grid, s.holds));
        std::printf("%-24s %6.3f %9.2f %9.2f %9.2f %10.2f %10.2f\n", s.name, agreement.dice,
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
