#include "app/modeller/commands/import_command.h"

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>

#include "app/modeller/commands/console.h"
#include "app/modeller/import/import.h"

namespace stylet::modeller {

namespace {

struct ImportArguments {
    ImportSettings settings;
    std::filesystem::path out;
    double spacing_mm = 1.0;
};

void printSources(const std::vector<SourceLabel>& sources) {
    std::printf("%9s  %-16s %10s %9s\n", "source id", "target", "ml", "mean HU");
    for (const SourceLabel& s : sources)
        std::printf("%9d  %-16s %10.2f %9.1f\n", s.id, s.target.empty() ? "(unmapped)" : s.target.c_str(),
                    s.volume_ml, s.mean_hu);
}

void runImport(ImportArguments& a) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
    a.settings.spacing_m = 1e-3 * a.spacing_mm;
    a.settings.defaults = tissueDefaults();
    a.settings.progress = [&](std::string_view stage) {
        std::fprintf(stderr, "%6.1f s  %.*s\n", seconds(), int(stage.size()), stage.data());
    };
    a.settings.list = printSources;
    const Imported imported = importPatient(a.settings);
    a.settings.progress("write");
    patient::savePackage(imported.package, a.out);
    const patient::Package& p = imported.package;
    for (const std::string& note : imported.notes)
        std::printf("%s\n", note.c_str());
    std::printf("thresholds: %.0f, %.0f, %.0f (outside the fascia), %.0f (past it) HU\n", p.thresholds.t0_hu,
                p.thresholds.t1_hu, p.thresholds.t2_sensitive_hu, p.thresholds.t2_specific_hu);
    std::printf("%s: %d x %d x %d voxels of %.2f mm, licence %s\n", a.out.c_str(), p.ct.grid.dims.x,
                p.ct.grid.dims.y, p.ct.grid.dims.z, a.spacing_mm, p.licence.c_str());
    a.settings.progress("done");
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
        ->capture_default_str();
    import
        ->add_option("--reference-phase", a.settings.reference_phase,
                     "Breathing phase of the CT: inhale, exhale or v=X.")
        ->capture_default_str();
    import->callback([arguments] { runImport(*arguments); });
}

}  // namespace stylet::modeller
