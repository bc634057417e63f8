// The command line of `stylet-report`. A training simulator, not a medical device.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "app/program_linux.h"
#include "app/report/commands.h"

static int program(int argc, char** argv) {
    CLI::App app(
        "Stylet's debriefs: one self-contained page each, that opens without a network, and CSV beside it.\n"
        "A training simulator, not a medical device.");
    app.require_subcommand(1);
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::report::ReportOptions o;
    const auto common = [&o](CLI::App* command) {
        command->add_option("--records", o.records, "the store (default: where \"stylet run\" keeps it)");
        command->add_option("--out", o.out, "folder for page and tables")->required();
        command
            ->add_option("--xapi-home", o.xapi.home,
                         "address under which the xAPI statements name trainees and scenarios")
            ->capture_default_str();
    };
    CLI::App* attempt = app.add_subcommand("attempt", "the debrief of one attempt: attempt.html");
    attempt
        ->add_option("attempt", o.attempt, "its id in the store, or a folder that \"stylet run\" has written")
        ->required();
    attempt->add_option("--reference", o.reference,
                        "another attempt, by id or folder, whose way in is drawn beside (an expert's)");
    attempt->add_option("--patient", o.patient, "patient package, if it has moved");
    common(attempt);
    CLI::App* trainee = app.add_subcommand("trainee", "one trainee over time: trainee.html");
    trainee->add_option("trainee", o.trainee, "the pseudonym")->required();
    trainee->add_option("--scenario", o.scenario, "only attempts at this scenario");
    common(trainee);
    CLI::App* cohort = app.add_subcommand("cohort", "all trainees side by side: cohort.html");
    cohort->add_option("--scenario", o.scenario, "only attempts at this scenario");
    common(cohort);
    CLI11_PARSE(app, argc, argv);
    try {
        const std::filesystem::path page = app.got_subcommand(attempt)   ? reportAttempt(o)
                                           : app.got_subcommand(trainee) ? reportTrainee(o)
                                                                         : reportCohort(o);
        std::printf("%s\n", page.c_str());
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "stylet-report: %s\n", e.what());
        return 2;
    }
}

int main(int argc, char** argv) {
    return stylet::runProgram("stylet-report", program, argc, argv);
}
