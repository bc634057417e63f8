#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "app/modeller/build/atlas.h"
#include "app/modeller/build/judgement.h"
#include "app/modeller/build/path_forces.h"
#include "app/modeller/commands.h"

namespace stylet::modeller {

namespace {

using patient::Package;

struct Options {
    std::string truth, found;
    std::size_t most_paths = 200;
};

void runCompare(const Options& o) {
    const Package truth = patient::loadPackage(o.truth);
    Package found = patient::loadPackage(o.found);
    refuseItself(truth.name, found.provenance);
    found.motion = truth.motion;  // one breath for both
    const patient::Patient true_patient(truth), found_patient(found);
    std::vector<patient::PlannedPath> paths = patient::planPaths(true_patient, {}).paths;
    if (paths.size() > o.most_paths) paths.resize(o.most_paths);
    std::printf("%-26s %6s %9s %9s %9s %9s %10s %10s\n", "structure", "Dice", "mean mm", "HD95 mm", "HD mm",
                "paths mm", "truth ml", "found ml");
    for (const auto& [structure, a] : judge(truth, found, paths))
        std::printf("%-26s %6.3f %9.2f %9.2f %9.2f %9.2f %10.2f %10.2f\n", structure.c_str(), a.dice,
                    1e3 * a.mean_surface_m, 1e3 * a.hausdorff95_m, 1e3 * a.hausdorff_m,
                    1e3 * a.mean_surface_there_m, a.truth_ml, a.found_ml);
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
