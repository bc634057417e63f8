// The command line of `stylet-report`. A training simulator, not a medical device.
#include <cstdio>

#include "app/program_linux.h"
#include "app/records/disk_linux.h"
#include "app/report/commands.h"

int main(int argc, char** argv) {
    stylet::records::makeNewFilesPrivate();
    CLI::App app(
        "Writes Stylet's debriefs: each is one self-contained HTML page that needs no network, with CSV "
        "tables.\n"
        "A training simulator, not a medical device.",
        "stylet-report");
    app.require_subcommand(1);
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::report::ReportOptions o;
    const auto common = [&o](CLI::App* command) {
        command->add_option("--records", o.records,
                            "Folder of the store (default: the store of \"stylet run\").");
        command->add_option("--out", o.out, "Folder for the page and its tables.")->required();
        command
            ->add_option("--xapi-home", o.xapi.home,
                         "Home address for trainees and scenarios in the xAPI statements.")
            ->capture_default_str();
    };
    CLI::App* attempt = app.add_subcommand("attempt", "Write the debrief of one attempt: attempt.html.");
    attempt
        ->add_option("attempt", o.attempt,
                     "Id of the attempt in the store, or a folder written by \"stylet run\".")
        ->required();
    attempt->add_option(
        "--reference", o.reference,
        "Another attempt (id or folder), for example an expert's, whose needle track is drawn beside.");
    attempt->add_flag("--cohort", o.cohort,
                      "Compare with the store's finished attempts at the same scenario.");
    attempt->add_option("--patient", o.patient, "Patient package, if it has moved.");
    common(attempt);
    CLI::App* trainee = app.add_subcommand("trainee", "Write a page of one trainee over time: trainee.html.");
    trainee->add_option("trainee", o.trainee, "Pseudonym of the trainee.")->required();
    trainee->add_option("--scenario", o.scenario, "Only attempts at this scenario.");
    common(trainee);
    CLI::App* cohort =
        app.add_subcommand("cohort", "Write a page of all trainees side by side: cohort.html.");
    cohort->add_option("--scenario", o.scenario, "Only attempts at this scenario.");
    common(cohort);
    return stylet::runProgram(app, argc, argv, [&] {
        const std::filesystem::path page = app.got_subcommand(attempt)   ? reportAttempt(o)
                                           : app.got_subcommand(trainee) ? reportTrainee(o)
                                                                         : reportCohort(o);
        std::printf("%s\n", page.c_str());
        return 0;
    });
}
