#include <fmt/core.h>
#include <csignal>
#include <cstdio>
#include <memory>

#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/console.h"
#include "app/modeller/import/section.h"
#include "app/modeller/segmentation/build.h"
#include "app/options.h"
#include "app/print.h"
#include "app/report/classes.h"
#include "base/path.h"

namespace stylet::modeller {

namespace {

struct BuildArguments {
    BuildSettings settings;
    std::filesystem::path out, labels;
    std::string stage;
    double spacing_mm = 1.0;
};

volatile std::sig_atomic_t interrupted = 0;

// Signal handler for Ctrl-C. The first Ctrl-C ends the build after the current stage. It also restores the
// default handler, so a second Ctrl-C ends the program immediately.
void onInterrupt(int signal) {
    interrupted = 1;
    std::signal(signal, SIG_DFL);
}

void printStages(const BuildResult& built) {
    printResult("{:<10} {:>8}  {}\n", "stage", "seconds", "notes");
    for (const StageReport& stage : built.stages) {
        printResult("{:<10} {:8.1f}  {}{}\n", stage.name, stage.seconds, stage.reused ? "kept " : "",
                    stage.corrected ? "corrected by hand" : "");
        for (const std::string& note : stage.notes)
            printResult("{:20}{}\n", "", note);
    }
}

// Draws the HU intervals of the threshold classes over the CT's histogram and over a slice through the liver,
// as in Figs. 10 to 13 of the AcusVR-4D paper.
void drawTissueClasses(const patient::Package& p, const std::filesystem::path& png) {
    const Mask liver = labelMask(p.labels, "liver");
    Vec3 sum{0.0};
    double count = 0.0;
    forEachVoxel(liver.grid, [&](const Index3& i) {
        if (liver[i]) sum += liver.grid.centre(i), count += 1.0;
    });
    const patient::Patient patient(p);
    if (count > 0.0) report::drawClasses(patient, sum / count, p.name, png);
}

void runBuild(BuildArguments& a) {
    BuildSettings& s = a.settings;
    s.spacing_m = 1e-3 * a.spacing_mm;
    if (s.stages.empty()) s.stages = withoutSlash(a.out).string() + "-stages";
    std::vector<std::filesystem::path> inputs{s.ct, s.stages, a.labels};
    inputs.insert(inputs.end(), s.atlases.begin(), s.atlases.end());
    checkOut(a.out, inputs);
    if (!a.stage.empty()) correctStage(s.stages, a.stage, a.labels);
    s.defaults = tissueDefaults();
    s.progress = progressBar("build");
    s.cancelled = [] { return interrupted != 0; };
    std::signal(SIGINT, onInterrupt);
    const BuildResult built = build(s);
    printStages(built);
    patient::savePackage(built.package, a.out);
    const bool plausible = printVerdict(built.package, a.out, built.findings);
    std::fflush(stdout);
    drawTissueClasses(built.package, s.stages / "02-classes" / "classes.png");
    printPackage(built.package, a.out);
    printResult("; stages in {}\n", s.stages.string());
    if (!plausible) {
        printResult(
            "The patient cannot be simulated yet. Correct the stages in question with --stage and "
            "--labels.\n");
        throw CLI::RuntimeError(1);
    }
}

}  // namespace

void addBuild(CLI::App& app) {
    const auto arguments = std::make_shared<BuildArguments>();
    BuildArguments& a = *arguments;
    CLI::App* command = app.add_subcommand("build", "Build a patient from a CT without a segmentation.");
    command->add_option("--ct", a.settings.ct, "CT: a DICOM folder or a NIfTI file.")->required();
    command->add_option("--series", a.settings.series,
                        "UID of the series to read, if the folder holds several.");
    command->add_option("--out", a.out, "Folder for the package.")->required();
    command->add_option("--stages", a.settings.stages,
                        "Folder for the stages, for review and correction (default: OUT-stages).");
    command->add_option("--atlas", a.settings.atlases,
                        "Packages whose livers serve as the atlas (default: reference patients).");
    command->add_flag("--virtual-ducts", a.settings.virtual_ducts,
                      "Grow dilated bile ducts beside the portal branches if the CT shows none.");
    command->add_flag("--trust-axes", a.settings.trust_axes,
                      "Accept a scan that looks mirrored, upside down or turned front to back.");
    command->add_option("--spacing-mm", a.spacing_mm, "Voxel size of the package [mm].")
        ->check(inRange(0.5, 4.0))
        ->capture_default_str();
    command
        ->add_option("--reference-phase", a.settings.reference_phase,
                     "Breathing phase of the CT: inhale, exhale or v=X.")
        ->capture_default_str();
    command->add_option("--name", a.settings.name, "Name of the patient.");
    command->add_option("--licence", a.settings.licence, "Licence of the images.");
    auto* labels =
        command->add_option("--labels", a.labels, "Corrected labels of the stage given by --stage.");
    auto* stage = command->add_option("--stage", a.stage, "Stage that --labels replaces.");
    labels->needs(stage);
    stage->needs(labels);
    command->callback([arguments] { runBuild(*arguments); });
}

}  // namespace stylet::modeller
