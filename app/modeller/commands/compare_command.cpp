#include <fmt/core.h>
#include <memory>

#include "app/modeller/commands/commands.h"
#include "app/modeller/segmentation/atlas.h"
#include "app/modeller/segmentation/judgement.h"
#include "app/print.h"
#include "app/study/study.h"

namespace stylet::modeller {

namespace {

using patient::Package;

struct CompareOptions {
    std::string truth, found;
    std::size_t max_paths = 200;
};

// Plans paths with a coarse grid, in the breathing state of the CT. Returns at most the `most` best ones.
std::vector<patient::PlannedPath> planBestPaths(const Package& package, std::size_t most) {
    const patient::Patient patient(package);
    patient::PlanSettings settings = patient::studyPlanSettings(patient);
    settings.skin_spacing_m = patient::PlanSettings().skin_spacing_m;
    settings.target_spacing_m = patient::PlanSettings().target_spacing_m;
    std::vector<patient::PlannedPath> paths = patient::planPaths(patient, settings).paths;
    if (paths.size() > most) paths.resize(most);
    return paths;
}

// Prints how many of the paths that the second package suggests cross a labelled risk structure of the first.
void printCrossings(const Package& truth, const std::vector<patient::PlannedPath>& paths) {
    std::size_t crossing = 0;
    std::string names;
    for (const auto& [name, count] : countRiskCrossings(truth, paths)) {
        crossing += count;
        names += fmt::format("{}{} {}", names.empty() ? ": " : ", ", name, count);
    }
    printResult("of {} paths planned in the second, {} cross a labelled risk structure of the first{}\n",
                paths.size(), crossing, names);
}

// Computes the forces along the paths in both packages, with the accuracy study's method, and prints how they
// differ. The second package is used with all of its labels (FoundLabels::all).
void printForces(const CompareOptions& o, Package truth, Package found,
                 const std::vector<patient::PlannedPath>& paths) try {
    const study::Pair pair = study::makePair({truth.name, o.truth, o.found}, std::move(truth),
                                             std::move(found), study::FoundLabels::all);
    const study::Summary s =
        study::summarise(pair.name, study::runPaths(study::PreparedPair(pair), paths, {}));
    printResult(
        "forces on {} paths planned in the first: RMS error {:.3f} N, median path {:.3f} N, worst path "
        "{:.3f} N, largest {:.2f} N, {:.1f} % of samples equal; {} of them end at bone\n",
        s.paths, s.pooled_rmse_n, s.rmse_n.median, s.rmse_n.max, s.max_n.max, 100.0 * s.equal_share.mean,
        s.bone_paths);
} catch (const DataError& e) {
    printResult("no forces to compare: {}\n", e.what());
}

void runCompare(const CompareOptions& o) {
    Package truth = patient::loadPackage(o.truth), found = patient::loadPackage(o.found);
    checkNotOwnAtlas(truth.name, found.atlases);
    const std::vector<patient::PlannedPath> paths = planBestPaths(truth, o.max_paths);
    printResult("{:<26} {:>6} {:>9} {:>9} {:>9} {:>9} {:>10} {:>10}\n", "structure", "Dice", "mean mm",
                "HD95 mm", "HD mm", "paths mm", "truth ml", "found ml");
    for (const auto& [structure, a] : compareStructures(truth, found, paths))
        printResult("{:<26} {:6.3f} {:9.2f} {:9.2f} {:9.2f} {:9.2f} {:10.2f} {:10.2f}\n", structure, a.dice,
                    1e3 * a.mean_surface_m, 1e3 * a.hausdorff95_m, 1e3 * a.hausdorff_m,
                    1e3 * a.mean_surface_near_m, a.truth_ml, a.found_ml);
    printCrossings(truth, planBestPaths(found, o.max_paths));
    if (paths.empty())
        printResult("no path can be planned in {}: no forces to compare\n", o.truth);
    else
        printForces(o, std::move(truth), std::move(found), paths);
}

}  // namespace

void addCompare(CLI::App& app) {
    const auto o = std::make_shared<CompareOptions>();
    CLI::App* command = app.add_subcommand(
        "compare", "Compare a package's labels, and the forces on its paths, with a reference package.");
    command->add_option("truth", o->truth, "Package with the true labels.")->required();
    command->add_option("found", o->found, "Package to compare, of the same CT.")->required();
    command->add_option("--paths", o->max_paths, "Number of planned paths to use, best first.")
        ->capture_default_str();
    command->callback([o] { runCompare(*o); });
}

}  // namespace stylet::modeller
