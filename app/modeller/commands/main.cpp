// stylet-model: makes, checks and shows virtual patients.
#include <iostream>

#include "app/modeller/commands/commands.h"
#include "app/modeller/commands/import_command.h"
#include "app/program_linux.h"

static int program(int argc, char** argv) {
    CLI::App app{
        "stylet-model: makes, checks and shows virtual patients.\n"
        "Part of a training simulator, not a medical device."};
    // Optional for the parser, so that an unknown word is reported before the missing command.
    app.require_subcommand(0, 1);
    app.callback([&app] {
        if (app.get_subcommands().empty())
            throw CLI::RequiredError("A command: synth, check, slices, import, build, compare or motion");
    });
    app.set_version_flag("--version", STYLET_VERSION);
    stylet::modeller::addSynth(app);
    stylet::modeller::addCheck(app);
    stylet::modeller::addSlices(app);
    stylet::modeller::addImport(app);
    stylet::modeller::addBuild(app);
    stylet::modeller::addCompare(app);
    stylet::modeller::addMotion(app);
    try {
        CLI11_PARSE(app, argc, argv);
    } catch (const std::exception& e) {
        std::cerr << "stylet-model: " << e.what() << '\n';
        return 2;
    }
    return 0;
}

int main(int argc, char** argv) {
    return stylet::runProgram("stylet-model", program, argc, argv);
}
