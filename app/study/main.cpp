// The command line of `stylet-study`.
#include <cstdio>
#include <exception>

#include "app/options.h"
#include "app/program_linux.h"
#include "app/study/commands.h"

namespace stylet::study {

namespace {

void addPlanOptions(CLI::App& command, StudyOptions& o) {
    command.add_option("study", o.study, "TOML file that lists the pairs.")->required();
    command.add_option("--out", o.out, "Folder for the results.")->required();
    const auto mark_explicit = [&o](const std::string&) { o.plan_is_explicit = true; };
    const auto add_spacing = [&](const char* name, double& spacing_m, const char* help) {
        const auto set = [&spacing_m](double mm) { spacing_m = 1e-3 * mm; };
        command.add_option_function<double>(name, set, help)->check(inRange(0.0, 50.0))->each(mark_explicit);
    };
    add_spacing("--skin-spacing-mm", o.plan.skin_spacing_m,
                "Spacing of the skin voxels at which paths begin [mm]; 0: every voxel.");
    add_spacing("--target-spacing-mm", o.plan.target_spacing_m,
                "Spacing of the duct voxels at which paths end [mm]; 0: every voxel.");
    command
        .add_option("--breaths", o.plan.breaths,
                    "Number of breathing phases in which to rate each path again.")
        ->check(inRange(5, 100))
        ->each(mark_explicit);
    command.add_flag("--accept-implausible", o.accept_implausible,
                     "Use packages that `stylet-model check` refused. The results and the page say so.");
    command.add_option("--threads", o.plan.threads, "Threads per process; they do not change the result.")
        ->check(inRange(1, 256))
        ->capture_default_str();
}

void addRunOptions(CLI::App& command, StudyOptions& o) {
    addPlanOptions(command, o);
    command.add_option("--paths", o.max_paths, "Number of paths of each pair, best first; 0: all.");
    command.add_option("--samples", o.run.steering.samples, "Minimum number of samples along a path.")
        ->check(inRange(100, 100000))
        ->capture_default_str();
    command.add_option("--sampled-paths", o.sampled_paths,
                       "Number of each pair's best paths for which to write the force at every sample.");
    command.add_flag("--breathing", o.run.steering.breathing,
                     "Let the patients breathe while the needle is steered.");
    command.add_flag_callback(
        "--published", [&o] { o.labels = FoundLabels::partial; },
        "Use the built patients as the paper's Algorithm 1 does: only their fascia, liver, vessels and "
        "ducts, "
        "elsewhere thresholds.");
}

void addCommands(CLI::App& app, StudyOptions& o) {
    addPlanOptions(*app.add_subcommand("plan", "Plan the paths of every pair's reference."), o);
    addRunOptions(*app.add_subcommand("run", "Steer the needle along the paths and compare the forces."), o);
    addRunOptions(*app.add_subcommand("all", "Plan if needed, run, and report."), o);
    app.add_subcommand("report", "Write the study as one page: OUT/report.html.")
        ->add_option("out", o.out, "Results folder of the study.")
        ->required();
}

int work(const CLI::App& app, StudyOptions o) {
    o.run.threads = o.plan.threads;
    const bool all = app.got_subcommand("all");
    const Ranks ranks;
    try {
        if (app.got_subcommand("plan")) runPlan(o, ranks);
        if (app.got_subcommand("run") || all) runStudy(o, ranks);
        if ((app.got_subcommand("report") || all) && ranks.first())
            std::printf("%s\n", writeReport(o.out).c_str());
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-study: %s\n", e.what());  // abort() may end the process
        ranks.abort();
        return 2;
    }
    return 0;
}

}  // namespace

}  // namespace stylet::study

int main(int argc, char** argv) {
    CLI::App app(
        "stylet-study: compares the forces of patients built from a CT alone with references of the same "
        "CT.\n"
        "Part of a training simulator, not a medical device.",
        "stylet-study");
    app.require_subcommand(1);
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::study::StudyOptions options;
    stylet::study::addCommands(app, options);
    return stylet::runProgram(app, argc, argv, [&] { return stylet::study::work(app, options); });
}
