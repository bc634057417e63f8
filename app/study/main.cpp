// The command line of `stylet-study`.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "app/study/commands.h"

int main(int argc, char** argv) {
    CLI::App app(
        "stylet-study: force errors of patients built from a CT alone, against references of the same CT");
    app.require_subcommand(1);
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::study::StudyOptions o;
    double skin_mm = 0.0, target_mm = 0.0;
    bool all_labels = false;
    const auto common = [&](CLI::App* command) {
        command->add_option("study", o.study, "TOML file that lists the pairs")->required();
        command->add_option("--out", o.out, "folder of what comes of it")->required();
        command->add_option("--skin-spacing-mm", skin_mm, "of the skin voxels planned from; 0: every one")
            ->check(CLI::Range(0.0, 50.0));
        command->add_option("--target-spacing-mm", target_mm, "of the duct's voxels planned to; 0: every one")
            ->check(CLI::Range(0.0, 50.0));
        command->add_option("--breaths", o.plan.breaths, "rate the paths anew in so many phases of a breath")
            ->check(CLI::Range(5, 100));
        command->add_option("--threads", o.plan.threads)->check(CLI::Range(1, 256))->capture_default_str();
    };
    CLI::App* plan = app.add_subcommand("plan", "plan the paths of every pair's reference");
    common(plan);
    CLI::App* run = app.add_subcommand("run", "steer down the paths and compare the forces");
    common(run);
    run->add_option("--paths", o.most_paths, "the best so many of each pair; 0: all");
    run->add_option("--samples", o.run.steering.samples, "of a path, at least")
        ->check(CLI::Range(100, 100000))
        ->capture_default_str();
    run->add_option("--sampled-paths", o.sampled_paths,
                    "write the forces at every sample of so many of each pair's best paths");
    run->add_flag("--breathing", o.run.steering.breathing,
                  "the patients breathe while the needle is steered");
    run->add_flag("--all-labels", all_labels,
                  "all labels of the built patients count, not only fascia, liver, vessels and ducts");
    CLI11_PARSE(app, argc, argv);
    o.plan.skin_spacing_m = 1e-3 * skin_mm;
    o.plan.target_spacing_m = 1e-3 * target_mm;
    o.run.threads = o.plan.threads;
    if (all_labels) o.labels = stylet::study::FoundLabels::all;
    try {
        app.got_subcommand(plan) ? stylet::study::runPlan(o) : stylet::study::runStudy(o);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-study: %s\n", e.what());
        return 2;
    }
}
