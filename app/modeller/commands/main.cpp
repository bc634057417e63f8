// stylet-model: makes, checks and shows virtual patients.
#include "app/modeller/commands/commands.h"
#include "app/program_linux.h"
#include "base/memory_linux.h"

int main(int argc, char** argv) {
    stylet::keepFreedMemory();
    CLI::App app{
        "stylet-model: makes, checks and shows virtual patients.\n"
        "Part of a training simulator, not a medical device.",
        "stylet-model"};
    // The callback, not the parser, checks that there is a command. An unknown word is then reported first.
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
    return stylet::runProgram(app, argc, argv, [] { return 0; });  // each command runs while it is parsed
}
