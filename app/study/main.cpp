// The command line of `stylet-study`.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "app/program_linux.h"
#include "app/study/commands.h"

static int program(int argc, char** argv) {
    CLI::App app(
        "stylet-study: force errors of patients built from a CT alone, against references of the same CT.\n"
        "Part of a training simulator, not a medical device.");
    app.require_subcommand(1);
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::study::StudyOptions o;
    double skin_mm = 0.0, target_mm = 0.0;
    bool all_labels = false;
    const auto planned = [&](CLI::App* command) {
        command->add_option("study", o.study, "TOML file that lists the pairs")->required();
        command->add_option("--out", o.out, "folder of what comes of it")->required();
        const auto asked = [&](const std::string&) { o.plan_is_asked = true; };
        command->add_option("--skin-spacing-mm", skin_mm, "of the skin voxels planned from; 0: every one")
            ->check(CLI::Range(0.0, 50.0))
            ->each(asked);
        command->add_option("--target-spacing-mm", target_mm, "of the duct's voxels planned to; 0: every one")
            ->check(CLI::Range(0.0, 50.0))
            ->each(asked);
        command->add_option("--breaths", o.plan.breaths, "rate the paths anew in so many phases of a breath")
            ->check(CLI::Range(5, 100))
            ->each(asked);
        command->add_option("--threads", o.plan.threads, "of each process; they do not change the result")
            ->check(CLI::Range(1, 256))
            ->capture_default_str();
    };
    const auto steered = [&](CLI::App* command) {
        command->add_option("--paths", o.most_paths, "the best so many of each pair; 0: all");
        command->add_option("--samples", o.run.steering.samples, "of a path, at least")
            ->check(CLI::Range(100, 100000))
            ->capture_default_str();
        command->add_option("--sampled-paths", o.sampled_paths,
                            "write the forces at every sample of so many of each pair's best paths");
        command->add_flag("--breathing", o.run.steering.breathing,
                          "the patients breathe while the needle is steered");
        command->add_flag(
            "--all-labels", all_labels,
            "all labels of the built patients count, not only fascia, liver, vessels and ducts");
    };
    CLI::App* plan = app.add_subcommand("plan", "plan the paths of every pair's reference");
    planned(plan);
    CLI::App* run = app.add_subcommand("run", "steer down the paths and compare the forces");
    CLI::App* all = app.add_subcommand("all", "plan where need be, run, and report");
    for (CLI::App* command : {run, all}) {
        planned(command);
        steered(command);
    }
    CLI::App* report = app.add_subcommand("report", "the study as one page: OUT/report.html");
    report->add_option("out", o.out, "folder that the study was run into")->required();
    CLI11_PARSE(app, argc, argv);
    o.plan.skin_spacing_m = 1e-3 * skin_mm;
    o.plan.target_spacing_m = 1e-3 * target_mm;
    o.run.threads = o.plan.threads;
    if (all_labels) o.labels = stylet::study::FoundLabels::all;
    const auto failed = [](const std::exception& e) {
        std::fprintf(stderr, "stylet-study: %s\n", e.what());
        return 2;
    };
    try {
        const stylet::study::Ranks ranks;
        try {
            if (app.got_subcommand(plan)) stylet::study::runPlan(o, ranks);
            if (app.got_subcommand(run) || app.got_subcommand(all)) stylet::study::runStudy(o, ranks);
            if ((app.got_subcommand(report) || app.got_subcommand(all)) && ranks.first())
                std::printf("%s\n", stylet::study::writeReport(o.out).c_str());
            return 0;
        } catch (const std::exception& e) {
            const int status = failed(e);
            ranks.giveUp();
            return status;
        }
    } catch (const std::exception& e) {
        return failed(e);
    }
}

int main(int argc, char** argv) {
    return stylet::runProgram("stylet-study", program, argc, argv);
}
