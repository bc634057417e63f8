// The command line of `stylet-study`.
#include <cstdio>
#include <exception>

#include "app/program_linux.h"
#include "app/study/commands.h"

int main(int argc, char** argv) {
    CLI::App app(
        "stylet-study: compares the forces of patients built from a CT alone with references of the same "
        "CT.\n"
        "Part of a training simulator, not a medical device.",
        "stylet-study");
    app.require_subcommand(1);
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::study::StudyOptions o;
    double skin_mm = 0.0, target_mm = 0.0;
    bool published = false;
    const auto planned = [&](CLI::App* command) {
        command->add_option("study", o.study, "TOML file that lists the pairs.")->required();
        command->add_option("--out", o.out, "Folder for the results.")->required();
        const auto mark_explicit = [&](const std::string&) { o.plan_is_explicit = true; };
        const auto spacing = [&](const char* name, double& mm, const char* help) {
            command->add_option(name, mm, help)->check(CLI::Range(0.0, 50.0))->each(mark_explicit);
        };
        spacing("--skin-spacing-mm", skin_mm,
                "Spacing of the skin voxels at which paths begin [mm]; 0: every voxel.");
        spacing("--target-spacing-mm", target_mm,
                "Spacing of the duct voxels at which paths end [mm]; 0: every voxel.");
        command
            ->add_option("--breaths", o.plan.breaths,
                         "Number of breathing phases in which to rate each path again.")
            ->check(CLI::Range(5, 100))
            ->each(mark_explicit);
        command->add_flag("--accept-implausible", o.accept_implausible,
                          "Use packages that `stylet-model check` refused. The results and the page say so.");
        command
            ->add_option("--threads", o.plan.threads, "Threads per process; they do not change the result.")
            ->check(CLI::Range(1, 256))
            ->capture_default_str();
    };
    const auto steered = [&](CLI::App* command) {
        command->add_option("--paths", o.max_paths, "Number of paths of each pair, best first; 0: all.");
        command->add_option("--samples", o.run.steering.samples, "Minimum number of samples along a path.")
            ->check(CLI::Range(100, 100000))
            ->capture_default_str();
        command->add_option("--sampled-paths", o.sampled_paths,
                            "Number of each pair's best paths for which to write the force at every sample.");
        command->add_flag("--breathing", o.run.steering.breathing,
                          "Let the patients breathe while the needle is steered.");
        command->add_flag("--published", published,
                          "Use the built patients as the paper's Algorithm 1 does: only their fascia, liver, "
                          "vessels and ducts, elsewhere thresholds.");
    };
    CLI::App* plan = app.add_subcommand("plan", "Plan the paths of every pair's reference.");
    planned(plan);
    CLI::App* run = app.add_subcommand("run", "Steer the needle along the paths and compare the forces.");
    CLI::App* all = app.add_subcommand("all", "Plan if needed, run, and report.");
    for (CLI::App* command : {run, all}) {
        planned(command);
        steered(command);
    }
    CLI::App* report = app.add_subcommand("report", "Write the study as one page: OUT/report.html.");
    report->add_option("out", o.out, "Results folder of the study.")->required();
    return stylet::runProgram(app, argc, argv, [&] {
        o.plan.skin_spacing_m = 1e-3 * skin_mm;
        o.plan.target_spacing_m = 1e-3 * target_mm;
        o.run.threads = o.plan.threads;
        if (published) o.labels = stylet::study::FoundLabels::partial;
        const stylet::study::Ranks ranks;
        try {
            if (app.got_subcommand(plan)) stylet::study::runPlan(o, ranks);
            if (app.got_subcommand(run) || app.got_subcommand(all)) stylet::study::runStudy(o, ranks);
            if ((app.got_subcommand(report) || app.got_subcommand(all)) && ranks.first())
                std::printf("%s\n", stylet::study::writeReport(o.out).c_str());
        } catch (const std::exception& e) {
            std::fprintf(stderr, "stylet-study: %s\n", e.what());  // abort() may end the process
            ranks.abort();
            return 2;
        }
        return 0;
    });
}
