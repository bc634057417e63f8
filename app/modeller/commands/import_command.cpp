#include <fmt/core.h>
#include <memory>

#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "app/modeller/import/import.h"
#include "app/options.h"
#include "app/print.h"

namespace stylet::modeller {

namespace {

struct ImportArguments {
    ImportSettings settings;
    std::filesystem::path out;
    double spacing_mm = 1.0;
};

void printSources(const std::vector<SourceLabel>& sources) {
    printResult("{:>9}  {:<16} {:>10} {:>9}\n", "source id", "target", "ml", "mean HU");
    for (const SourceLabel& s : sources)
        printResult("{:9}  {:<16} {:10.2f} {:9.1f}\n", s.id, s.target.empty() ? "(unmapped)" : s.target,
                    s.volume_ml, s.mean_hu);
}

void runImport(ImportArguments& a) {
    checkOut(a.out, {a.settings.ct, a.settings.labels, a.settings.map});
    a.settings.spacing_m = 1e-3 * a.spacing_mm;
    a.settings.defaults = tissueDefaults();
    a.settings.progress = timedProgress();
    a.settings.list = printSources;
    const ImportResult imported = importPatient(a.settings);
    a.settings.progress("write");
    patient::savePackage(imported.package, a.out);
    for (const std::string& note : imported.notes)
        printResult("{}\n", note);
    printPackage(imported.package, a.out);
    printResult(", licence {}\n", imported.package.licence);
    a.settings.progress("check");
    const bool plausible = printVerdict(imported.package, a.out, checkPackage(imported.package));
    a.settings.progress("done");
    if (plausible) return;
    printResult(
        "The patient cannot be simulated yet. Correct the segmentation or the map, and import it again.\n"
        "If the segmentation lacks organs, run stylet-model build instead: it segments the CT itself.\n");
    throw CLI::RuntimeError(1);
}

}  // namespace

void addImport(CLI::App& app) {
    auto arguments = std::make_shared<ImportArguments>();
    CLI::App* import = app.add_subcommand("import", "Build a patient from a CT and its segmentation.");
    ImportArguments& a = *arguments;
    import->add_option("--ct", a.settings.ct, "CT: a DICOM folder or a NIfTI file.")->required();
    import->add_option("--series", a.settings.series,
                       "UID of the series to read, if the folder holds several.");
    import->add_option("--labels", a.settings.labels, "Segmentation: a NIfTI file on the grid of the CT.")
        ->required();
    import
        ->add_option("--map", a.settings.map,
                     "CSV file source_id,tissue with one line for each id of the segmentation.")
        ->required();
    import->add_option("--out", a.out, "Folder for the package.")->required();
    import->add_flag("--grow-ducts", a.settings.grow_ducts,
                     "Grow dilated bile ducts beside the portal branches.");
    import->add_option("--spacing-mm", a.spacing_mm, "Voxel size of the package [mm].")
        ->check(inRange(0.5, 4.0))
        ->capture_default_str();
    import
        ->add_option("--reference-phase", a.settings.reference_phase,
                     "Breathing phase of the CT: inhale, exhale or v=X.")
        ->capture_default_str();
    import->callback([arguments] { runImport(*arguments); });
}

}  // namespace stylet::modeller
